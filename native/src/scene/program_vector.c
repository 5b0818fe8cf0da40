/* Operations on coordinates and normals. */
#include <math.h>

#include "scene/fresnel.h"
#include "scene/microfacet.h"
#include "scene/program.h"

static vec3 object_from_world_point(const shade_point *p, vec3 v)
{
  return p->object_from_world ? mat4_point(p->object_from_world, v) : v;
}
/* Normals are covectors: they go by the transpose of the inverse. */
static vec3 object_from_world_normal(const shade_point *p, vec3 n)
{
  return p->world_from_object ? v3_normalize(mat4_transposed_vector(p->world_from_object, n)) : n;
}
static vec3 world_from_object_normal(const shade_point *p, vec3 n)
{
  return p->object_from_world ? v3_normalize(mat4_transposed_vector(p->object_from_world, n)) : n;
}

static int is_mirrored(const mat4 *m)
{
  if (!m) return 0;
  const double(*a)[4] = m->m;
  return v3_dot(v3_cross(v3_from(a[0]), v3_from(a[1])), v3_from(a[2])) < 0;
}

static vec3 object_location(const shade_point *p)
{
  return p->world_from_object ? mat4_point(p->world_from_object, v3(0, 0, 0)) : v3(0, 0, 0);
}
/* Along the surface, around the z axis of the object. */
static vec3 radial_tangent(const shade_point *p)
{
  const vec3 around = world_from_object_normal(p, v3(0.5 - p->generated.y, p->generated.x - 0.5, 0));
  return v3_cross(p->normal, v3_normalize(v3_cross(around, p->normal)));
}

OPERATION(coordinate)
{
  const shade_point *p = context->point;
  switch ((coordinate_kind)immediates[0]) {
    case COORDINATE_UV: *out = v3(p->uv[0], p->uv[1], 0); break;
    case COORDINATE_GENERATED: *out = p->generated; break;
    case COORDINATE_OBJECT: *out = object_from_world_point(p, p->position); break;
    case COORDINATE_NORMAL: *out = object_from_world_normal(p, p->normal); break;
    case COORDINATE_REFLECTION: *out = reflect(p->wo, p->normal); break;
    case COORDINATE_POSITION: *out = p->position; break;
    case COORDINATE_SHADING_NORMAL: *out = p->normal; break;
    case COORDINATE_TRUE_NORMAL: *out = p->geometric_normal; break;
    case COORDINATE_TANGENT: *out = radial_tangent(p); break;
    case COORDINATE_INCOMING: *out = p->wo; break;
    case COORDINATE_PARAMETRIC: /* the weights of the first two corners */
      *out = v3(1 - p->barycentric[0] - p->barycentric[1], p->barycentric[0], 0);
      break;
    case COORDINATE_BACKFACING: *out = v3_splat(p->backfacing); break;
    case COORDINATE_OBJECT_LOCATION: *out = object_location(p); break;
    case COORDINATE_OBJECT_COLOR: *out = v3(p->object_color[0], p->object_color[1], p->object_color[2]); break;
    case COORDINATE_OBJECT_ALPHA: *out = v3_splat(p->object_color[3]); break;
    case COORDINATE_OBJECT_INDEX: *out = v3_splat(p->object_index); break;
    case COORDINATE_OBJECT_RANDOM: *out = v3_splat(p->object_random); break;
    case COORDINATE_RAY_LENGTH: *out = v3_splat(p->ray_length); break;
    case COORDINATE_BEAM: /* where the light goes, in the axes of the object */
      *out = v3_normalize(p->object_from_world ? mat4_vector(p->object_from_world, p->wo) : p->wo);
      break;
  }
}

OPERATION(light_path)
{
  const ray_history *ray = &context->point->ray;
  double value = 0;
  switch ((light_path_kind)immediates[0]) {
    case PATH_IS_CAMERA: value = (ray->kinds & RAY_CAMERA) != 0; break;
    case PATH_IS_SHADOW: value = (ray->kinds & RAY_SHADOW) != 0; break;
    case PATH_RAY_DEPTH: value = ray->bounces; break;
    case PATH_TRANSPARENT_DEPTH: value = ray->transparent; break;
    case PATH_IS_DIFFUSE: value = (ray->kinds & RAY_DIFFUSE) != 0; break;
    case PATH_IS_GLOSSY: value = (ray->kinds & RAY_GLOSSY) != 0; break;
    case PATH_IS_SINGULAR: value = (ray->kinds & RAY_SINGULAR) != 0; break;
    case PATH_IS_REFLECTION: value = (ray->kinds & RAY_REFLECTION) != 0; break;
    case PATH_IS_TRANSMISSION: value = (ray->kinds & RAY_TRANSMISSION) != 0; break;
    case PATH_DIFFUSE_DEPTH: value = ray->diffuse; break;
    case PATH_GLOSSY_DEPTH: value = ray->glossy; break;
    case PATH_TRANSMISSION_DEPTH: value = ray->transmission; break;
  }
  *out = v3_splat(value);
}

OPERATION(fresnel)
{
  const double ior = fmax(in[0]->x, 1e-5), cosine = fabs(v3_dot(context->point->wo, *in[1]));
  *out = v3_splat(fresnel_dielectric(cosine, context->point->backfacing ? 1 / ior : ior, NULL));
}

OPERATION(layer_weight)
{
  const double blend = in[0]->x, cosine = fabs(v3_dot(context->point->wo, *in[1])), inverse = fmax(1 - blend, 1e-5);
  out[0] = v3_splat(fresnel_dielectric(cosine, context->point->backfacing ? inverse : 1 / inverse, NULL));
  const double b = fmin(fmax(blend, 0), 1 - 1e-5);
  out[1] = v3_splat(1 - (b == 0.5 ? cosine : pow(cosine, b < 0.5 ? 2 * b : 0.5 / (1 - b))));
}

OPERATION(transform)
{
  const vec3 v = *in[0];
  *out = v3_add(v3_add(v3_scale(*in[1], v.x), v3_scale(*in[2], v.y)), v3_add(v3_scale(*in[3], v.z), *in[4]));
}

/* Columns of the rotation by Euler angles in the order X, Y, Z. */
static void euler_columns(vec3 angles, vec3 columns[3])
{
  const double cx = cos(angles.x), sx = sin(angles.x), cy = cos(angles.y), sy = sin(angles.y), cz = cos(angles.z),
               sz = sin(angles.z);
  columns[0] = v3(cy * cz, cy * sz, -sy);
  columns[1] = v3(sx * sy * cz - cx * sz, sx * sy * sz + cx * cz, sx * cy);
  columns[2] = v3(cx * sy * cz + sx * sz, cx * sy * sz - sx * cz, cx * cy);
}
static vec3 divide(vec3 a, vec3 b)
{
  return v3(b.x != 0 ? a.x / b.x : 0, b.y != 0 ? a.y / b.y : 0, b.z != 0 ? a.z / b.z : 0);
}

OPERATION(mapping)
{
  const vec3 location = *in[1], scale = *in[3];
  const mapping_type type = immediates[0];
  vec3 v = *in[0], r[3];
  euler_columns(*in[2], r);
  if (type == MAPPING_TEXTURE) {
    v = v3_sub(v, location);
    *out = divide(v3(v3_dot(r[0], v), v3_dot(r[1], v), v3_dot(r[2], v)), scale);
    return;
  }
  v = type == MAPPING_NORMAL ? divide(v, scale) : v3_mul(v, scale);
  v = v3_add(v3_add(v3_scale(r[0], v.x), v3_scale(r[1], v.y)), v3_scale(r[2], v.z));
  *out = type == MAPPING_POINT ? v3_add(v, location) : type == MAPPING_NORMAL ? v3_normalize(v) : v;
}

/* By Rodrigues' formula. */
OPERATION(rotate)
{
  const vec3 v = v3_sub(*in[0], *in[1]), axis = v3_normalize(*in[2]);
  const double c = cos(in[3]->x), s = sin(in[3]->x);
  if (!(v3_dot(axis, axis) > 0)) {
    *out = *in[0];
    return;
  }
  const vec3 turned = v3_mad(v3_cross(axis, v), s, v3_mad(axis, v3_dot(axis, v) * (1 - c), v3_scale(v, c)));
  *out = v3_add(turned, *in[1]);
}

OPERATION(change_space)
{
  const shade_point *p = context->point;
  const vector_type type = immediates[0];
  const int to_object = immediates[2] && !immediates[1], to_world = immediates[1] && !immediates[2];
  const mat4 *matrix = to_object ? p->object_from_world : to_world ? p->world_from_object : NULL;
  vec3 v = *in[0];
  if (type == VECTOR_TYPE_POINT) v = matrix ? mat4_point(matrix, v) : v;
  else if (type == VECTOR_TYPE_VECTOR) v = matrix ? mat4_vector(matrix, v) : v;
  else v = v3_normalize(to_object ? object_from_world_normal(p, v) : to_world ? world_from_object_normal(p, v) : v);
  *out = v;
}

/* A normal of the tangent space, in the object's axes: there is where it is defined, and only then is it stretched. */
static vec3 object_from_tangent(const shade_point *p, vec3 c)
{
  const vec3 normal = object_from_world_normal(p, p->backfacing ? v3_scale(p->normal, -1) : p->normal);
  const vec3 along = p->object_from_world ? mat4_vector(p->object_from_world, p->tangent) : p->tangent;
  const vec3 tangent = v3_normalize(v3_mad(normal, -v3_dot(normal, along), along));
  const double sign = is_mirrored(p->world_from_object) ? -p->tangent_sign : p->tangent_sign;
  const vec3 bitangent = v3_scale(v3_cross(normal, tangent), sign);
  return v3_add(v3_add(v3_scale(tangent, c.x), v3_scale(bitangent, c.y)), v3_scale(normal, c.z));
}

OPERATION(tangent)
{
  const shade_point *p = context->point;
  const vec3 along = world_from_object_normal(p, *in[0]);
  *out = v3_cross(p->normal, v3_normalize(v3_cross(along, p->normal)));
}

/* Strength, color. Tangent space needs a UV map; without one the normal stays. */
OPERATION(normal_map)
{
  const shade_point *p = context->point;
  const normal_space space = immediates[0];
  const double strength = fmax(in[0]->x, 0);
  vec3 c = v3_sub(v3_scale(*in[1], 2), v3_splat(1)), n;
  if (space == SPACE_TANGENT) {
    if (v3_dot(p->tangent, p->tangent) == 0) {
      *out = p->normal;
      return;
    }
    c = v3(c.x * strength, c.y * strength, 1 + (c.z - 1) * saturate(strength));
    n = world_from_object_normal(p, object_from_tangent(p, c));
  } else {
    if (space == SPACE_BLENDER_OBJECT || space == SPACE_BLENDER_WORLD) c = v3(c.x, -c.y, -c.z);
    n = space == SPACE_OBJECT || space == SPACE_BLENDER_OBJECT ? world_from_object_normal(p, c) : c;
  }
  n = v3_normalize(p->backfacing ? v3_scale(n, -1) : n);
  if (space != SPACE_TANGENT && strength != 1) n = v3_normalize(v3_mad(v3_sub(n, p->normal), strength, p->normal));
  *out = v3_dot(n, n) > 0 ? n : p->normal;
}

/* Tangent space of tangents that are interpolated as the normals are, neither made unit again (as in Cycles). */
OPERATION(normal_map_along)
{
  const shade_point *p = context->point;
  const double strength = fmax(in[0]->x, 0);
  const vec3 c = v3_sub(v3_scale(*in[1], 2), v3_splat(1)), tangent = *in[2];
  if (v3_dot(tangent, tangent) == 0) { /* the mesh has none: that of the triangle */
    op_normal_map(context, in, (const int32_t[]){SPACE_TANGENT}, out);
    return;
  }
  const vec3 unit = object_from_world_normal(p, p->backfacing ? v3_scale(p->normal, -1) : p->normal);
  const vec3 normal = p->normal_length > 0 ? v3_scale(unit, p->normal_length) : unit;
  const vec3 bitangent = v3_scale(v3_cross(normal, tangent), in[3]->x);
  const vec3 mapped = v3_add(v3_add(v3_scale(tangent, c.x * strength), v3_scale(bitangent, c.y * strength)),
                             v3_scale(normal, 1 + (c.z - 1) * saturate(strength)));
  const vec3 n = world_from_object_normal(p, v3_normalize(mapped));
  *out = v3_dot(n, n) > 0 ? (p->backfacing ? v3_scale(n, -1) : n) : p->normal;
}
