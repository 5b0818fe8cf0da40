/* Adding and changing meshes and instances: arguments are checked and copied here; commit.c builds from the copies. */
#include <stdlib.h>
#include <string.h>

#include "geometry/mesh.h"
#include "scene/scene.h"

/* Embree ignores triangles with a coordinate beyond this (its FLT_LARGE). */
static const double LARGEST_COORDINATE = 1.844e18;

/* Makes room for one more element. */
static void *grow(void *array, size_t count, size_t *capacity, size_t size)
{
  if (count < *capacity) return array;
  const size_t wanted = *capacity ? 2 * *capacity : 16;
  void *grown = realloc(array, wanted * size);
  if (grown) *capacity = wanted;
  return grown;
}

/* A copy with `padding` zero bytes after it; NULL stays NULL. Failure clears *ok. */
static void *copy(const void *data, size_t bytes, size_t padding, int *ok)
{
  if (!data) return NULL;
  char *out = malloc(bytes + padding + 1);
  if (!out) {
    *ok = 0;
    return NULL;
  }
  memcpy(out, data, bytes);
  memset(out + bytes, 0, padding + 1);
  return out;
}

void mesh_clear(mesh *m)
{
  const embree_table *e = embree();
  if (m->triangle) e->release_geometry(m->triangle);
  if (m->scene) e->release_scene(m->scene);
  void *const arrays[] = {m->vertices,  m->triangles, m->corner_normals, m->corner_uvs,
                          m->material_slots, m->generated, m->built};
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) free(arrays[i]);
  attributes_free(&m->attributes);
}

void instance_clear(instance *i)
{
  free(i->materials);
  attributes_free(&i->attributes);
}

static bent_status check_finite(const char *name, size_t n, const float (*v)[3], bent_error *error)
{
  for (size_t i = 0; i < n; i++)
    if (!isfinite(v[i][0]) || !isfinite(v[i][1]) || !isfinite(v[i][2]))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "%s: row %zu contains NaN or infinity", name, i);
  return BENT_OK;
}

static bent_status check_mesh(const bent_mesh *data, bent_error *error)
{
  if (data->vertex_count > UINT32_MAX - 1 || data->triangle_count > INT32_MAX)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "mesh: too many vertices or triangles");
  if ((data->vertex_count && !data->vertices) || (data->triangle_count && !data->triangles))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "mesh: vertices and triangles are needed");
  for (size_t i = 0; i < data->triangle_count; i++)
    for (int c = 0; c < 3; c++)
      if (data->triangles[i][c] >= data->vertex_count)
        return bent_fail(error, BENT_ERROR_ARGUMENT, "triangles: triangle %zu names vertex %u of %zu", i,
                         data->triangles[i][c], data->vertex_count);
  return check_finite("vertices", data->vertex_count, data->vertices, error);
}

bent_status bent_scene_add_mesh(bent_scene *scene, const bent_mesh *data, int *index, bent_error *error)
{
  bent_status status = check_mesh(data, error);
  if (status) return status;
  geometry *g = scene->geometry;
  mesh *grown = grow(g->meshes, g->mesh_count, &g->mesh_capacity, sizeof *g->meshes);
  if (!grown) return bent_fail(error, BENT_ERROR_MEMORY, "mesh: out of memory");
  g->meshes = grown;
  const size_t v = data->vertex_count, t = data->triangle_count;
  int ok = 1;
  mesh m = {.vertex_count = v,
            .triangle_count = t,
            .vertices = copy(data->vertices, v * sizeof *data->vertices, 16, &ok),
            .triangles = copy(data->triangles, t * sizeof *data->triangles, 16, &ok),
            .corner_normals = copy(data->corner_normals, t * sizeof *data->corner_normals, 0, &ok),
            .corner_uvs = copy(data->corner_uvs, t * sizeof *data->corner_uvs, 0, &ok),
            .material_slots = copy(data->material_slots, t * sizeof *data->material_slots, 0, &ok),
            .generated = copy(data->generated, v * sizeof *data->generated, 0, &ok)};
  if (!ok) {
    mesh_clear(&m);
    return bent_fail(error, BENT_ERROR_MEMORY, "mesh: out of memory");
  }
  *index = (int)g->mesh_count;
  g->meshes[g->mesh_count++] = m;
  scene_edited(scene);
  g->changed = 1;
  return BENT_OK;
}

/* NULL, and the error filled with BENT_ERROR_ARGUMENT, if there is no such mesh. */
static mesh *find_mesh(const geometry *g, int index, bent_error *error)
{
  if (index >= 0 && (size_t)index < g->mesh_count) return &g->meshes[index];
  bent_fail(error, BENT_ERROR_ARGUMENT, "mesh: there is no mesh %d, the scene has %zu", index, g->mesh_count);
  return NULL;
}

bent_status bent_scene_update_mesh(bent_scene *scene, int index, const bent_mesh *data, bent_error *error)
{
  geometry *g = scene->geometry;
  mesh *m = find_mesh(g, index, error);
  if (!m) return BENT_ERROR_ARGUMENT;
  if (data->vertex_count != m->vertex_count ||
      (data->corner_normals && data->triangle_count != m->triangle_count))
    return bent_fail(error, BENT_ERROR_ARGUMENT, "mesh %d: an update must keep %zu vertices and %zu triangles", index,
                     m->vertex_count, m->triangle_count);
  const bent_status status = check_finite("vertices", m->vertex_count, data->vertices, error);
  if (status) return status;
  int ok = 1;
  void *normals = copy(data->corner_normals, m->triangle_count * sizeof *m->corner_normals, 0, &ok);
  void *generated = copy(data->generated, m->vertex_count * sizeof *m->generated, 0, &ok);
  if (!m->built && m->scene) m->built = copy(m->vertices, m->vertex_count * sizeof *m->vertices, 0, &ok);
  if (!ok) {
    free(normals), free(generated);
    return bent_fail(error, BENT_ERROR_MEMORY, "mesh: out of memory");
  }
  if (normals) free(m->corner_normals), m->corner_normals = normals;
  if (generated) free(m->generated), m->generated = generated;
  if (m->vertex_count) memcpy(m->vertices, data->vertices, m->vertex_count * sizeof *m->vertices);
  m->moved = 1;
  scene_edited(scene);
  g->changed = 1;
  return BENT_OK;
}

/* The inverse of an affine matrix. Returns the determinant divided by the product of the columns' lengths: 1 for
 * orthogonal columns at any scale, 0 for a singular matrix. */
static double affine_inverse(const mat4 *a, mat4 *inverse)
{
  const vec3 x = v3(a->m[0][0], a->m[1][0], a->m[2][0]), y = v3(a->m[0][1], a->m[1][1], a->m[2][1]),
             z = v3(a->m[0][2], a->m[1][2], a->m[2][2]), t = v3(a->m[0][3], a->m[1][3], a->m[2][3]);
  const double lx = v3_length(x), ly = v3_length(y), lz = v3_length(z);
  const vec3 ux = v3_scale(x, 1 / lx), uy = v3_scale(y, 1 / ly), uz = v3_scale(z, 1 / lz);
  const vec3 yz = v3_cross(uy, uz), zx = v3_cross(uz, ux), xy = v3_cross(ux, uy);
  const double det = v3_dot(ux, yz);
  const vec3 rows[3] = {v3_scale(yz, 1 / (det * lx)), v3_scale(zx, 1 / (det * ly)), v3_scale(xy, 1 / (det * lz))};
  for (int i = 0; i < 3; i++) {
    v3_to(inverse->m[i], rows[i]);
    inverse->m[i][3] = -v3_dot(rows[i], t);
    inverse->m[3][i] = 0;
  }
  inverse->m[3][3] = 1;
  return det;
}

bent_status affine_check(const char *name, const double matrix[4][4], mat4 *inverse, bent_error *error)
{
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++)
      if (!isfinite(matrix[i][j])) return bent_fail(error, BENT_ERROR_ARGUMENT, "%s: contains NaN or infinity", name);
  if (matrix[3][0] != 0 || matrix[3][1] != 0 || matrix[3][2] != 0 || matrix[3][3] != 1)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "%s: the last row must be 0 0 0 1 (an affine matrix)", name);
  mat4 a;
  memcpy(a.m, matrix, sizeof a.m);
  const double det = affine_inverse(&a, inverse);
  int fits = fabs(det) > 1e-9; /* false for NaN; beyond it Embree's float32 inverse has no digit left */
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++)
      fits = fits && fabs(matrix[i][j]) < LARGEST_COORDINATE && fabs(inverse->m[i][j]) < LARGEST_COORDINATE;
  if (!fits) return bent_fail(error, BENT_ERROR_ARGUMENT, "%s: the matrix is singular, or its scale is out of range", name);
  return BENT_OK;
}

static bent_status set_transform(instance *i, const double world_from_mesh[4][4], bent_error *error)
{
  mat4 inverse;
  const bent_status status = affine_check("world_from_mesh", world_from_mesh, &inverse, error);
  if (status) return status;
  memcpy(i->world_from_mesh.m, world_from_mesh, sizeof i->world_from_mesh.m);
  i->mesh_from_world = inverse;
  return BENT_OK;
}

bent_status bent_scene_add_instance(bent_scene *scene, const bent_instance *data, int *index, bent_error *error)
{
  geometry *g = scene->geometry;
  if (!find_mesh(g, data->mesh, error)) return BENT_ERROR_ARGUMENT;
  if (data->receiver_set >= BENT_LINK_SETS || data->blocker_set >= BENT_LINK_SETS)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "instance: receiver_set and blocker_set must be below 64, got %u and %u",
                     data->receiver_set, data->blocker_set);
  instance *grown = grow(g->instances, g->instance_count, &g->instance_capacity, sizeof *g->instances);
  if (!grown) return bent_fail(error, BENT_ERROR_MEMORY, "instance: out of memory");
  g->instances = grown;
  instance i = {.mesh = data->mesh,
                .material_count = data->materials ? data->material_count : 0,
                .visibility = data->visibility,
                .object_index = data->object_index,
                .random = data->random,
                .one_sided = data->one_sided,
                .influence = data->influence,
                .receiver_set = data->receiver_set,
                .blocker_set = data->blocker_set};
  memcpy(i.color, data->color, sizeof i.color);
  const bent_status status = set_transform(&i, data->world_from_mesh, error);
  if (status) return status;
  int ok = 1;
  i.materials = copy(data->materials, i.material_count * sizeof *i.materials, 0, &ok);
  if (!ok) return bent_fail(error, BENT_ERROR_MEMORY, "instance: out of memory");
  *index = (int)g->instance_count;
  g->instances[g->instance_count++] = i;
  scene_edited(scene);
  g->changed = 1;
  return BENT_OK;
}

static bent_status check_instance(const geometry *g, int index, bent_error *error)
{
  if (index >= 0 && (size_t)index < g->instance_count) return BENT_OK;
  return bent_fail(error, BENT_ERROR_ARGUMENT, "instance: there is no instance %d, the scene has %zu", index,
                   g->instance_count);
}

bent_status bent_scene_set_mesh_attribute(bent_scene *scene, int index, int id, int components, size_t triangle_count,
                                          const float *values, bent_error *error)
{
  mesh *m = find_mesh(scene->geometry, index, error);
  if (!m) return BENT_ERROR_ARGUMENT;
  if (triangle_count != m->triangle_count)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "attribute: values of %zu triangles, mesh %d has %zu", triangle_count,
                     index, m->triangle_count);
  scene_edited(scene);
  return attribute_set(&m->attributes, id, components, 3 * triangle_count, values, "attribute", error);
}

bent_status bent_scene_set_instance_attribute(bent_scene *scene, int index, int id, const float value[4],
                                              bent_error *error)
{
  const bent_status status = check_instance(scene->geometry, index, error);
  if (status) return status;
  scene_edited(scene);
  return attribute_set(&scene->geometry->instances[index].attributes, id, 4, 1, value, "attribute", error);
}

bent_status bent_scene_update_instance(bent_scene *scene, int index, const double world_from_mesh[4][4],
                                       bent_error *error)
{
  geometry *g = scene->geometry;
  bent_status status = check_instance(g, index, error);
  if (!status) status = set_transform(&g->instances[index], world_from_mesh, error);
  if (status) return status;
  scene_edited(scene);
  g->changed = 1;
  return BENT_OK;
}

bent_status bent_scene_clear_instances(bent_scene *scene, bent_error *error)
{
  (void)error;
  geometry *g = scene->geometry;
  for (size_t i = 0; i < g->instance_count; i++) instance_clear(&g->instances[i]);
  g->instance_count = 0;
  scene_edited(scene);
  g->changed = 1;
  return BENT_OK;
}

/* A triangle that no ray can meet: `too_large` beyond Embree's range, `degenerate` without an area in float32. */
static void classify(const mesh *m, const uint32_t t[3], bent_mesh_report *out)
{
  const float *v[3] = {m->vertices[t[0]], m->vertices[t[1]], m->vertices[t[2]]};
  float e[2][3];
  for (int k = 0; k < 3; k++) {
    for (int c = 0; c < 3; c++)
      if (fabs((double)v[c][k]) > LARGEST_COORDINATE) {
        out->too_large++;
        return;
      }
    e[0][k] = v[1][k] - v[0][k], e[1][k] = v[2][k] - v[0][k];
  }
  const vec3 n = v3_cross(v3(e[0][0], e[0][1], e[0][2]), v3(e[1][0], e[1][1], e[1][2]));
  out->degenerate += !(fmax(fabs(n.x), fmax(fabs(n.y), fabs(n.z))) > 1.2e-38); /* smallest normal float32 */
}

typedef struct corners {
  float v[9];
} corners;

static int compare_corners(const void *a, const void *b) { return memcmp(a, b, sizeof(corners)); }
static int compare_vertices(const void *a, const void *b) { return memcmp(a, b, 3 * sizeof(float)); }

bent_status bent_scene_report_mesh(const bent_scene *scene, int index, bent_mesh_report *out, bent_error *error)
{
  const mesh *m = find_mesh(scene->geometry, index, error);
  if (!m) return BENT_ERROR_ARGUMENT;
  *out = (bent_mesh_report){0};
  corners *all = malloc((m->triangle_count + 1) * sizeof *all);
  if (!all) return bent_fail(error, BENT_ERROR_MEMORY, "mesh report: out of memory");
  for (size_t t = 0; t < m->triangle_count; t++) {
    classify(m, m->triangles[t], out);
    for (int c = 0; c < 3; c++) memcpy(&all[t].v[3 * c], m->vertices[m->triangles[t][c]], 3 * sizeof(float));
    qsort(all[t].v, 3, 3 * sizeof(float), compare_vertices);
  }
  qsort(all, m->triangle_count, sizeof *all, compare_corners);
  for (size_t t = 1; t < m->triangle_count; t++) out->duplicate += !compare_corners(&all[t - 1], &all[t]);
  free(all);
  return BENT_OK;
}
