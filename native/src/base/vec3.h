/* Small double-precision vectors and 4x4 matrices (row-major, column vectors) for scalar code. */
#ifndef BENT_BASE_VEC3_H
#define BENT_BASE_VEC3_H
#include <math.h>

/* The smaller and the larger number; b if one is NaN. Unlike fmin and fmax no calls of libm. */
static inline double min2(double a, double b) { return a < b ? a : b; }
static inline double max2(double a, double b) { return a > b ? a : b; }

typedef struct vec3 {
  double x, y, z;
} vec3;

static inline vec3 v3(double x, double y, double z) { return (vec3){x, y, z}; }
static inline vec3 v3_from(const double a[3]) { return (vec3){a[0], a[1], a[2]}; }
static inline void v3_to(double out[3], vec3 a) { out[0] = a.x, out[1] = a.y, out[2] = a.z; }
static inline vec3 v3_add(vec3 a, vec3 b) { return (vec3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec3 v3_sub(vec3 a, vec3 b) { return (vec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec3 v3_scale(vec3 a, double s) { return (vec3){a.x * s, a.y * s, a.z * s}; }
static inline vec3 v3_mul(vec3 a, vec3 b) { return (vec3){a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline vec3 v3_mad(vec3 a, double s, vec3 b) { return (vec3){a.x * s + b.x, a.y * s + b.y, a.z * s + b.z}; }
static inline double v3_dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline vec3 v3_cross(vec3 a, vec3 b)
{
  return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/* The length of (x, y). hypot would be slower and need glibc 2.35; its care for overflow is not needed here. */
static inline double v2_length(double x, double y) { return sqrt(x * x + y * y); }
static inline double v3_length(vec3 a) { return sqrt(v3_dot(a, a)); }
/* The zero vector stays zero. */
static inline vec3 v3_normalize(vec3 a)
{
  double length = v3_length(a);
  return length > 0 ? v3_scale(a, 1 / length) : a;
}
/* Unit vectors that make a right-handed basis (x, y, z) with the unit vector z: Duff et al., "Building an Orthonormal
 * Basis, Revisited" (JCGT 2017). */
static inline void v3_basis(vec3 z, vec3 *x, vec3 *y)
{
  const double sign = copysign(1, z.z), a = -1 / (sign + z.z), b = z.x * z.y * a;
  *x = v3(1 + sign * z.x * z.x * a, sign * b, -sign * z.x);
  *y = v3(b, sign + z.y * z.y * a, -z.y);
}
static inline int v3_is_finite(vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }
/* Of colors. */
static inline vec3 v3_splat(double x) { return (vec3){x, x, x}; }
static inline double v3_average(vec3 a) { return (a.x + a.y + a.z) * (1.0 / 3); }
static inline double v3_max(vec3 a) { return max2(a.x, max2(a.y, a.z)); }
static inline double saturate(double x) { return x > 0 ? (x < 1 ? x : 1) : 0; }
static inline vec3 v3_saturate(vec3 a) { return (vec3){saturate(a.x), saturate(a.y), saturate(a.z)}; }

typedef struct mat4 {
  double m[4][4];
} mat4;

static inline vec3 mat4_point(const mat4 *a, vec3 p)
{
  const double(*m)[4] = a->m;
  return (vec3){m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
                m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
                m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]};
}
static inline vec3 mat4_vector(const mat4 *a, vec3 v)
{
  const double(*m)[4] = a->m;
  return (vec3){m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}
/* Applies the transpose of the upper 3x3 block: with a = mesh_from_world this carries a normal from mesh to world. */
static inline vec3 mat4_transposed_vector(const mat4 *a, vec3 v)
{
  const double(*m)[4] = a->m;
  return (vec3){m[0][0] * v.x + m[1][0] * v.y + m[2][0] * v.z, m[0][1] * v.x + m[1][1] * v.y + m[2][1] * v.z,
                m[0][2] * v.x + m[1][2] * v.y + m[2][2] * v.z};
}
#endif
