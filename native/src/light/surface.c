/* See surface.h. */
#include "light/surface.h"

#include "geometry/geometry.h"
#include "scene/scene.h"

/* Turns a scene covector, and vectors, into the local frame at one place. */
typedef struct local_frame {
  const lens *lens;     /* NULL: the scene's axes are the local frame, up to a factor */
  vec3 from_covector[3]; /* rows, in the spacetime's axes */
} local_frame;

static local_frame frame_at(const geometry *g, vec3 position)
{
  local_frame frame = {.lens = geometry_lens_at(g, position)};
  if (!frame.lens) return frame;
  const bent_spacetime *s = &frame.lens->spacetime;
  if (s->chart != BENT_CHART_AREAL && s->chart != BENT_CHART_OBLATE) {
    frame.lens = NULL;
    return frame;
  }
  double local[3], m[3][3];
  v3_to(local, mat4_point(&frame.lens->spacetime_from_world, position));
  bent_local_from_covector(s, local, m);
  for (int i = 0; i < 3; i++) frame.from_covector[i] = v3_from(m[i]);
  return frame;
}

/* Local components e_(a)^i n_i of a covector, up to a positive factor. */
static vec3 local_covector(const local_frame *frame, vec3 covector)
{
  if (!frame->lens) return covector;
  const vec3 n = mat4_transposed_vector(&frame->lens->world_from_spacetime, covector), *row = frame->from_covector;
  const vec3 local = v3(v3_dot(row[0], n), v3_dot(row[1], n), v3_dot(row[2], n));
  return mat4_vector(&frame->lens->world_from_spacetime, local);
}

/* Local components e^(a)_i t^i of a vector: the inverse transpose, here as the cofactors. Not normalized. */
static vec3 local_vector(const local_frame *frame, vec3 vector)
{
  if (!frame->lens) return vector;
  const vec3 t = mat4_vector(&frame->lens->spacetime_from_world, vector), *row = frame->from_covector;
  const vec3 local = v3(v3_dot(v3_cross(row[1], row[2]), t), v3_dot(v3_cross(row[2], row[0]), t),
                        v3_dot(v3_cross(row[0], row[1]), t));
  return mat4_vector(&frame->lens->world_from_spacetime, local);
}

static vec3 vertex(const mesh *m, uint32_t index)
{
  const float *v = m->vertices[index];
  return v3(v[0], v[1], v[2]);
}

/* Weighted sum of three float triples. */
static vec3 blend(const double w[3], const float a[3], const float b[3], const float c[3])
{
  return v3(w[0] * a[0] + w[1] * b[0] + w[2] * c[0], w[0] * a[1] + w[1] * b[1] + w[2] * c[1],
            w[0] * a[2] + w[1] * b[2] + w[2] * c[2]);
}

/* The tangent dP/du where the UV map is not degenerate. */
static void set_tangent(shade_point *p, const float (*uv)[2], vec3 edge1, vec3 edge2, const instance *inst,
                        const local_frame *frame, vec3 own_normal)
{
  const double du1 = uv[1][0] - uv[0][0], dv1 = uv[1][1] - uv[0][1];
  const double du2 = uv[2][0] - uv[0][0], dv2 = uv[2][1] - uv[0][1], determinant = du1 * dv2 - du2 * dv1;
  if (determinant == 0) return;
  const vec3 du = v3_scale(v3_sub(v3_scale(edge1, dv2), v3_scale(edge2, dv1)), 1 / determinant);
  const vec3 dv = v3_scale(v3_sub(v3_scale(edge2, du1), v3_scale(edge1, du2)), 1 / determinant);
  const vec3 u = local_vector(frame, mat4_vector(&inst->world_from_mesh, du));
  const vec3 v = local_vector(frame, mat4_vector(&inst->world_from_mesh, dv));
  p->tangent = v3_normalize(v3_mad(own_normal, -v3_dot(own_normal, u), u));
  p->tangent_sign = v3_dot(v3_cross(own_normal, p->tangent), v) < 0 ? -1 : 1;
}

void surface_at(const bent_scene *scene, const bent_hit *hit, double length, surface *out)
{
  const geometry *g = scene->geometry;
  const instance *inst = &g->instances[hit->instance];
  const mesh *m = &g->meshes[inst->mesh];
  const uint32_t *corner = m->triangles[hit->triangle];
  const double w[3] = {1 - hit->barycentric[0] - hit->barycentric[1], hit->barycentric[0], hit->barycentric[1]};
  const vec3 v0 = vertex(m, corner[0]);
  const vec3 edge1 = v3_sub(vertex(m, corner[1]), v0), edge2 = v3_sub(vertex(m, corner[2]), v0);
  const vec3 position = v3_from(hit->position);
  const local_frame frame = frame_at(g, position);

  out->material = geometry_material(g, inst, hit->triangle);
  shade_point *const p = &out->point;
  *p = (shade_point){.position = position, .wo = v3_scale(v3_from(hit->direction), -1),
                     .object_index = inst->object_index, .object_random = inst->random, .tangent_sign = 1,
                     .ray_length = length,
                     .object_color = {inst->color[0], inst->color[1], inst->color[2], inst->color[3]},
                     .barycentric = {hit->barycentric[0], hit->barycentric[1]},
                     .world_from_object = &inst->world_from_mesh, .object_from_world = &inst->mesh_from_world,
                     .mesh_attributes = &m->attributes, .instance_attributes = &inst->attributes,
                     .triangle = hit->triangle, .scene = scene, .instance = hit->instance,
                   .edges = {edge1, edge2}};
  vec3 own = v3_normalize(local_covector(&frame, mat4_transposed_vector(&inst->mesh_from_world, v3_cross(edge1, edge2))));
  if (!(v3_dot(own, own) > 0.5)) own = p->wo; /* a triangle without area is seen face on */
  vec3 smooth = own;
  if (m->corner_normals) {
    const float(*n)[3] = m->corner_normals[hit->triangle];
    const vec3 blended = blend(w, n[0], n[1], n[2]);
    p->normal_length = v3_length(blended);
    smooth = v3_normalize(local_covector(&frame, mat4_transposed_vector(&inst->mesh_from_world, blended)));
    if (!(v3_dot(smooth, own) > 0)) smooth = own; /* garbage, or so coarse that it points inside */
  }
  if (m->corner_uvs) {
    const float(*uv)[2] = p->corner_uvs = m->corner_uvs[hit->triangle];
    for (int i = 0; i < 2; i++) p->uv[i] = w[0] * uv[0][i] + w[1] * uv[1][i] + w[2] * uv[2][i];
    if (shading_asks_tangent(scene->shading, out->material)) set_tangent(p, uv, edge1, edge2, inst, &frame, smooth);
  }
  for (int i = 0; m->generated && i < 3; i++) p->corner_generated[i] = m->generated[corner[i]];
  if (m->generated)
    p->generated = blend(w, m->generated[corner[0]], m->generated[corner[1]], m->generated[corner[2]]);
  p->backfacing = v3_dot(own, p->wo) < 0;
  p->geometric_normal = p->backfacing ? v3_scale(own, -1) : own;
  p->normal = p->backfacing ? v3_scale(smooth, -1) : smooth;

  out->see_through = inst->one_sided && p->backfacing;
}

int surface_is_backfacing(const bent_scene *scene, const bent_hit *hit)
{
  const geometry *g = scene->geometry;
  const instance *inst = &g->instances[hit->instance];
  const mesh *m = &g->meshes[inst->mesh];
  const uint32_t *corner = m->triangles[hit->triangle];
  const vec3 v0 = vertex(m, corner[0]);
  const vec3 own = v3_cross(v3_sub(vertex(m, corner[1]), v0), v3_sub(vertex(m, corner[2]), v0));
  const local_frame frame = frame_at(g, v3_from(hit->position));
  return v3_dot(local_covector(&frame, mat4_transposed_vector(&inst->mesh_from_world, own)), v3_from(hit->direction)) > 0;
}
