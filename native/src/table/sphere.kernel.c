/* Filling and reading the columns of a lens sphere over SIMD lanes. */
#include "table/sphere_data.h"

#include <string.h>

#include "bentlight/trace.h"
#include "table/fit.h"
#include "table/sphere_integrals.h"

/* Filling -------------------------------------------------------------------------------------------------------- */

/* What a column stores at TABLE_WIDTH sizes, and the cosines there. */
static void direct_all(const bent_sphere *sphere, int column, const double *sizes, double out[SPHERE_VALUES][TABLE_WIDTH],
                       double *cosines)
{
  for (int i = 0; i < TABLE_WIDTH; i += LANES) {
    lanes size, cosine;
    memcpy(&size, sizes + i, sizeof size);
    inside direct = inside_direct(sphere, column, size, &cosine);
    if (column == SPHERE_DOWN) cosine = lanes_all(1);
    direct.swept /= cosine, direct.length /= cosine;
    memcpy(&out[SPHERE_SWEPT][i], &direct.swept, sizeof direct.swept);
    memcpy(&out[SPHERE_LENGTH][i], &direct.length, sizeof direct.length);
    memcpy(&cosines[i], &cosine, sizeof cosine);
  }
}

/* The columns' values at a size in [2^-SPHERE_OCTAVES, 1). */
LANES_INLINE inside look_up(const bent_sphere *sphere, lanes_mask down, lanes size)
{
  const lanes_mask bits = (lanes_mask)size;
  const int64_t base = (int64_t)(1023 - SPHERE_OCTAVES) << SPHERE_MANTISSA_BITS;
  const int64_t rest = (INT64_C(1) << (52 - SPHERE_MANTISSA_BITS)) - 1;
  const lanes_mask row = (bits >> (52 - SPHERE_MANTISSA_BITS)) - base + (down & (SPHERE_OCTAVES * SPHERE_SEGMENTS));
  const lanes one_to = (lanes)((bits & rest) | 0x3ff0000000000000LL); /* 1 to 1 + 1/8 across the segment */
  const lanes x = (one_to - (1 + 0.5 / SPHERE_SEGMENTS)) * (2 * SPHERE_SEGMENTS);
  int64_t index[LANES];
  memcpy(index, &row, sizeof row);
  const double *values = sphere->columns[0][0][0];
  const size_t width = SPHERE_VALUES * TABLE_WIDTH;
  lanes swept = gather(values, width, index, TABLE_TERMS - 1), length = gather(values, width, index, width - 1);
  for (int k = TABLE_TERMS - 2; k >= 0; k--) {
    swept = swept * x + gather(values, width, index, k);
    length = length * x + gather(values, width, index, TABLE_WIDTH + k);
  }
  return (inside){swept, length};
}

static void fill_segment(bent_sphere *sphere, int column, int octave, int segment)
{
  double sizes[TABLE_WIDTH], direct[SPHERE_VALUES][TABLE_WIDTH], looked_up[SPHERE_VALUES][TABLE_WIDTH];
  double cosines[TABLE_WIDTH];
  double(*row)[TABLE_WIDTH] = sphere->columns[column][octave * SPHERE_SEGMENTS + segment];
  const double scale = ldexp(1, octave - SPHERE_OCTAVES), half = 0.5 / SPHERE_SEGMENTS;
  const double middle = 1 + (segment + 0.5) / SPHERE_SEGMENTS;
  for (int k = 0; k < TABLE_WIDTH; k++) sizes[k] = scale * (middle + half * chebyshev_node(k, TABLE_TERMS));
  direct_all(sphere, column, sizes, row, cosines);
  for (int v = 0; v < SPHERE_VALUES; v++) fit(row[v], 1, TABLE_TERMS);
  for (int k = 0; k < TABLE_WIDTH; k++) sizes[k] = scale * (middle + half * (2 * k + 1 - TABLE_WIDTH) / TABLE_WIDTH);
  direct_all(sphere, column, sizes, direct, cosines);
  for (int i = 0; i < TABLE_WIDTH; i += LANES) {
    lanes size;
    memcpy(&size, sizes + i, sizeof size);
    const inside found = look_up(sphere, lanes_mask_all(column == SPHERE_DOWN), size);
    memcpy(&looked_up[SPHERE_SWEPT][i], &found.swept, sizeof found.swept);
    memcpy(&looked_up[SPHERE_LENGTH][i], &found.length, sizeof found.length);
  }
  for (int v = 0; v < SPHERE_VALUES; v++) {
    for (int k = 0; k < TABLE_WIDTH; k++) direct[v][k] *= cosines[k], looked_up[v][k] *= cosines[k];
    note_errors(looked_up[v], direct[v], TABLE_WIDTH, &sphere->errors[v]);
  }
}

void BENT_KERNEL(sphere_fill)(bent_sphere *sphere)
{
  for (int column = 0; column < SPHERE_COLUMNS; column++)
    for (int octave = 0; octave < SPHERE_OCTAVES; octave++)
      for (int segment = 0; segment < SPHERE_SEGMENTS; segment++) fill_segment(sphere, column, octave, segment);
}

/* Reading -------------------------------------------------------------------------------------------------------- */

/* Rays by the column's two numbers, and where they leave: cosine and sine to the outward radial there. */
typedef struct passing {
  lanes_mask fate;
  lanes swept, length, error;
  lanes cosine, sine, radius;
} passing;

/* The part of an answer that both ways through share. `delta` is known to `uncertain`. */
LANES_INLINE passing pass(const bent_sphere *sphere, lanes delta, lanes uncertain, lanes cosine)
{
  const lanes_mask down = delta < 0;
  const lanes size = lanes_select(down, -delta, delta * (1 / sphere->delta_max));
  const lanes low = lanes_all(1.0 / (INT64_C(1) << SPHERE_OCTAVES)), high = lanes_all(0x1.fffffffffffffp-1);
  const inside found = look_up(sphere, down, lanes_min(lanes_max(size, low), high));
  const lanes factor = lanes_select(down, lanes_all(1), cosine);
  passing p;
  p.swept = factor * found.swept, p.length = factor * found.length * sphere->unit;
  p.error = sphere->measured.swept_max + 4 * DBL_EPSILON * (1 + p.swept) + uncertain / lanes_abs(delta);
  p.fate = (size >= low) & (lanes_abs(delta) > 4 * uncertain) & lanes_is_finite(p.swept);
  return p;
}

static void save(const aim *a, const passing *p, size_t first, size_t n, const bent_crossing *out)
{
  lanes sine, cosine;
  lanes_sincos(lanes_select(p->fate != 0, p->swept, lanes_all(0)), &sine, &cosine);
  for (size_t i = 0; i < LANES && first + i < n; i++) {
    const size_t at = first + i;
    const int ends = p->fate[i] != BENT_UNRESOLVED, leaves = ends && p->fate[i] != BENT_CAPTURED;
    out->fate[at] = (uint8_t)p->fate[i];
    out->swept[at] = ends ? p->swept[i] : NAN;
    out->length[at] = ends ? p->length[i] : NAN;
    out->error[at] = ends ? p->error[i] : NAN;
    for (int k = 0; k < 3; k++) {
      const double outward = a->outward[k][i], sideward = a->sideward[k][i];
      const double n_k = outward * cosine[i] + sideward * sine[i], e_k = sideward * cosine[i] - outward * sine[i];
      out->exit[at][k] = leaves ? p->radius[i] * n_k : NAN;
      out->direction[at][k] = leaves ? p->cosine[i] * n_k + p->sine[i] * e_k : NAN;
    }
  }
}

void BENT_KERNEL(sphere_cross)(const bent_sphere *sphere, size_t n, const double (*points)[3],
                               const double (*directions)[3], const bent_crossing *out)
{
  const int is_ellis = sphere->spacetime.kind == BENT_ELLIS;
  for (size_t first = 0; first < n; first += LANES) {
    lanes position[3], direction[3];
    lanes_load_rows(points, NULL, first, n, position);
    lanes_load_rows(directions, NULL, first, n, direction);
    const aim a = aim_from(position, direction);
    const lanes b = a.sine * (1 / sphere->critical), delta = b - 1;
    /* A start that rounding has put beside the sphere is off across it by about as much. */
    const lanes beside = lanes_abs(a.radius * (1 / sphere->radius) - 1);
    passing p = pass(sphere, delta, (4 * DBL_EPSILON + beside) * (b + 1 / sphere->critical), -a.cosine);
    p.error += beside;
    const lanes_mask down = delta < 0, through = down & lanes_mask_all(is_ellis);
    p.fate &= (a.cosine < 0) & ((~down & BENT_ESCAPED) | (down & (is_ellis ? BENT_ESCAPED_FAR : BENT_CAPTURED)));
    /* back: the way out mirrors the way in; at the throat sin = b / rho */
    p.radius = lanes_select(through, lanes_all(0.5 * sphere->spacetime.throat_radius), lanes_all(sphere->radius));
    p.sine = lanes_select(through, b, a.sine);
    p.cosine = lanes_select(through, -lanes_sqrt(lanes_max(-delta * (1 + b), lanes_all(0))), -a.cosine);
    save(&a, &p, first, n, out);
  }
}

void BENT_KERNEL(sphere_emerge)(const bent_sphere *sphere, size_t n, const double (*points)[3],
                                const double (*directions)[3], const bent_crossing *out)
{
  for (size_t first = 0; first < n; first += LANES) {
    lanes position[3], direction[3];
    lanes_load_rows(points, NULL, first, n, position);
    lanes_load_rows(directions, NULL, first, n, direction);
    const aim a = aim_from(position, direction);
    const lanes delta = -a.cosine * a.cosine / (1 + a.sine); /* sine - 1, b / rho being the sine at the throat */
    passing p = pass(sphere, delta, 4 * DBL_EPSILON * (lanes_abs(a.cosine) + DBL_EPSILON), a.cosine);
    p.fate &= (a.cosine > 0) & BENT_ESCAPED & lanes_mask_all(sphere->spacetime.kind == BENT_ELLIS);
    p.radius = lanes_all(sphere->radius);
    p.sine = sphere->critical * a.sine;
    p.cosine = lanes_sqrt((1 - p.sine) * (1 + p.sine));
    save(&a, &p, first, n, out);
  }
}
