/* The spacetime objects of a scene: checking how they are placed, and which one owns a point. */
#include <stdlib.h>
#include <string.h>

#include "geometry/mesh.h"
#include "scene/scene.h"

/* Blender's matrices are float32: a rotation is orthogonal to about 1e-6 there. */
static const double ROTATION_TOLERANCE = 1e-5;

/* Splits the matrix into rotation, uniform scale and translation, and makes the rotation exact. */
static bent_status place(lens *out, size_t index, const double matrix[4][4], bent_error *error)
{
  mat4 inverse;
  const bent_status status = affine_check("world_from_spacetime", matrix, &inverse, error);
  if (status) return status;
  vec3 column[3];
  double length[3];
  for (int c = 0; c < 3; c++) {
    column[c] = v3(matrix[0][c], matrix[1][c], matrix[2][c]);
    length[c] = v3_length(column[c]);
    column[c] = v3_scale(column[c], 1 / length[c]);
  }
  const double scale = (length[0] + length[1] + length[2]) / 3;
  for (int c = 0; c < 3; c++) {
    if (fabs(length[c] / scale - 1) > ROTATION_TOLERANCE)
      return bent_fail(error, BENT_ERROR_ARGUMENT, "spacetime object %zu: its scale must be the same on all axes, got "
                       "%g, %g, %g", index, length[0], length[1], length[2]);
    if (fabs(v3_dot(column[c], column[(c + 1) % 3])) > ROTATION_TOLERANCE)
      return bent_fail(error, BENT_ERROR_ARGUMENT, "spacetime object %zu: its matrix must not shear", index);
  }
  const vec3 z = column[2], y = v3_normalize(v3_cross(z, column[0])), x = v3_cross(y, z);
  if (v3_dot(y, column[1]) < 0)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "spacetime object %zu: its matrix must not mirror", index);
  out->center = v3(matrix[0][3], matrix[1][3], matrix[2][3]);
  out->scale = scale;
  const vec3 axes[3] = {x, y, z};
  double *const origin[3] = {&out->center.x, &out->center.y, &out->center.z};
  memset(&out->world_from_spacetime, 0, sizeof out->world_from_spacetime);
  memset(&out->spacetime_from_world, 0, sizeof out->spacetime_from_world);
  for (int c = 0; c < 3; c++) {
    const double axis[3] = {axes[c].x, axes[c].y, axes[c].z};
    for (int r = 0; r < 3; r++) {
      out->world_from_spacetime.m[r][c] = scale * axis[r];
      out->spacetime_from_world.m[c][r] = axis[r] / scale;
    }
    out->world_from_spacetime.m[c][3] = *origin[c];
    out->spacetime_from_world.m[c][3] = -v3_dot(axes[c], out->center) / scale;
  }
  out->world_from_spacetime.m[3][3] = out->spacetime_from_world.m[3][3] = 1;
  return BENT_OK;
}

/* Radius 0 asks for the default: the whole of space for a lone object, else what its neighbors leave, half-way where
 * a neighbor has the default too. */
static double default_radius(size_t count, const bent_spacetime_object *objects, const lens *lenses, size_t i)
{
  if (count == 1) return INFINITY;
  double radius = INFINITY;
  for (size_t j = 0; j < count; j++) {
    if (j == i) continue;
    const double distance = v3_length(v3_sub(lenses[j].center, lenses[i].center));
    radius = fmin(radius, objects[j].sphere_radius > 0 ? distance - objects[j].sphere_radius : distance / 2);
  }
  return radius;
}

static bent_status check_spheres(size_t count, const lens *lenses, bent_error *error)
{
  for (size_t i = 0; i < count; i++) {
    const lens *a = &lenses[i];
    const double core = bent_spacetime_core_radius(&a->spacetime) * a->scale;
    if (!(a->radius > core))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "spacetime object %zu: its sphere of radius %g must be larger than "
                       "its horizon or throat, radius %g", i, a->radius, core);
    if (count > 1 && !isfinite(a->radius))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "spacetime object %zu: with several objects each needs a sphere of "
                       "finite radius", i);
    for (size_t j = 0; j < i; j++) {
      const double distance = v3_length(v3_sub(a->center, lenses[j].center));
      if (distance < (a->radius + lenses[j].radius) * (1 - 1e-9))
        return bent_fail(error, BENT_ERROR_ARGUMENT, "spacetime objects %zu and %zu overlap: their spheres of radius %g "
                         "and %g are %g apart", j, i, lenses[j].radius, a->radius, distance);
    }
  }
  return BENT_OK;
}

static bent_status check_exits(size_t count, const lens *lenses, bent_error *error)
{
  for (size_t i = 0; i < count; i++) {
    const int exit = lenses[i].exit;
    if (exit == -1) continue;
    if (exit < 0 || (size_t)exit >= count || (size_t)exit == i)
      return bent_fail(error, BENT_ERROR_ARGUMENT, "spacetime object %zu: exit %d is not another object", i, exit);
    const lens *a = &lenses[i], *b = &lenses[exit];
    if (a->spacetime.kind != BENT_ELLIS || b->spacetime.kind != BENT_ELLIS)
      return bent_fail(error, BENT_ERROR_ARGUMENT, "spacetime objects %zu and %d: only wormholes have exits", i, exit);
    if (b->exit != (int)i)
      return bent_fail(error, BENT_ERROR_ARGUMENT, "wormhole %d must have %zu as its exit, as it is the exit of %zu",
                       exit, i, i);
    const double rho_a = a->spacetime.throat_radius * a->scale, rho_b = b->spacetime.throat_radius * b->scale;
    if (fabs(rho_a - rho_b) > ROTATION_TOLERANCE * rho_a)
      return bent_fail(error, BENT_ERROR_ARGUMENT, "wormhole mouths %zu and %d: their throats must be equally wide, got "
                       "radius %g and %g", i, exit, rho_a, rho_b);
  }
  return BENT_OK;
}

bent_status bent_scene_set_spacetimes(bent_scene *scene, size_t count, const bent_spacetime_object *objects,
                                      bent_error *error)
{
  lens *lenses = calloc(count + 1, sizeof *lenses);
  if (!lenses) return bent_fail(error, BENT_ERROR_MEMORY, "spacetime objects: out of memory");
  bent_status status = BENT_OK;
  for (size_t i = 0; i < count && !status; i++) {
    status = place(&lenses[i], i, objects[i].world_from_spacetime, error);
    lenses[i].spacetime = objects[i].spacetime;
    lenses[i].exit = objects[i].exit;
    lenses[i].flat = bent_spacetime_is_flat(&objects[i].spacetime);
    if (!status && !(objects[i].sphere_radius >= 0))
      status = bent_fail(error, BENT_ERROR_ARGUMENT, "spacetime object %zu: sphere_radius must not be negative or NaN", i);
  }
  for (size_t i = 0; i < count && !status; i++)
    lenses[i].radius =
        objects[i].sphere_radius > 0 ? objects[i].sphere_radius : default_radius(count, objects, lenses, i);
  if (!status) status = check_spheres(count, lenses, error);
  if (!status) status = check_exits(count, lenses, error);
  if (status) {
    free(lenses);
    return status;
  }
  geometry *g = scene->geometry;
  lenses_free(g->lenses, g->lens_count);
  g->lenses = lenses;
  g->lens_count = count;
  scene_edited(scene);
  return BENT_OK;
}

void lenses_free(lens *lenses, size_t count)
{
  for (size_t i = 0; i < count; i++) {
    bent_table_free(lenses[i].table);
    for (size_t j = i + 1; j < count; j++)
      if (lenses[j].sphere == lenses[i].sphere) lenses[j].sphere = NULL; /* shared */
    bent_sphere_free(lenses[i].sphere);
  }
  free(lenses);
}

const lens *geometry_lens_at(const geometry *g, vec3 position)
{
  for (size_t i = 0; i < g->lens_count; i++) {
    const lens *l = &g->lenses[i];
    if (!l->flat && v3_length(v3_sub(position, l->center)) < l->radius) return l;
  }
  return NULL;
}

double geometry_lens_distance(const geometry *g, vec3 position)
{
  double least = INFINITY;
  for (size_t i = 0; i < g->lens_count; i++)
    if (!g->lenses[i].flat) least = min2(least, v3_length(v3_sub(position, g->lenses[i].center)));
  return least;
}
