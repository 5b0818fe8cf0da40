/* The weights of all ways to make one path: multiple importance sampling for bidirectional path tracing.
 *
 * A path x_0 (camera) ... x_k (lamp) may be made with its last s vertices traced from the lamp and the others from the
 * camera, s = 0 .. k, joined by a connection between the two parts (s = 0: the camera's rays meet the lamp; 1: the lamp's
 * place is drawn for x_k-1). Each way is weighed by the square of the density with which it makes the path (power
 * heuristic: Veach & Guibas 1995). The sum over the ways with fewer vertices on one side grows with that side's subpath,
 * as van Antwerpen (2011) and Georgiev et al. (2012, "VCM") have it, here for curved arcs:
 *
 * - The density by area of a vertex is its predecessor's pdf by solid angle times cosine / spread, the spread taken in
 *   the direction of travel (light/join.h). For arcs that both sides trace only the ratio of the two spreads matters,
 *   (nu / nu')^2 by light/frequency.h, which needs no connection.
 * - A way whose connection is an arc that no joint is known for, as by way of two objects, does not exist: its density is
 *   0 on both sides (chain_arrive's spread 0). Of images that are listed by chance the chance is part of the density.
 * - Mirrors and smooth glass count as pdf 1 both ways; arcs that begin or end there are not connected. What one side
 *   cannot turn around (mirror rays that are lifted above a bumpy surface) has pdf_back 0.
 * - Russian roulette and passes through transparent surfaces are left out, on both sides.
 */
#ifndef BENT_RENDER_CHAIN_H
#define BENT_RENDER_CHAIN_H

/* One end of a subpath. "Back" is the other side's pdf, towards the predecessor. All but pdf and frequency are squares. */
typedef struct chain {
  double pdf;       /* of the direction in which the last vertex was left, by solid angle */
  double frequency; /* at the last vertex */
  double carried;   /* there: the sum but for what only the next vertex knows */
  int sharp;        /* it was left by a mirror or smooth glass */
  double once, more; /* on arrival: the sum is once + pdf_back^2 more */
} chain;

static inline double chain_squared(double x) { return x * x; }

/* On arrival at a vertex with that cosine to its surface. spread: of the arc, times its chance; 0 if no connection is known. */
static inline chain chain_arrive(const chain *left, double frequency, double cosine, double spread)
{
  chain c = *left;
  const double scale = 1 / (c.pdf * cosine);
  c.once = c.sharp ? 0 : chain_squared(spread * scale);
  c.more = chain_squared(chain_squared(c.frequency / frequency) * scale) * c.carried;
  c.frequency = frequency;
  return c;
}

/* The pdf with which the other side would have come back from a vertex; rough: it could also be connected with there. */
typedef struct chain_back {
  double pdf;
  int rough;
} chain_back;

/* The sum at a vertex, without the other side's density of the vertex itself. */
static inline double chain_sum(const chain *c, chain_back back)
{
  return (back.rough ? c->once : 0) + chain_squared(back.pdf) * c->more;
}

/* The vertex is left in a direction of that pdf and cosine. */
static inline void chain_leave(chain *c, double pdf, double cosine, int sharp, chain_back back)
{
  if (sharp) back.rough = 0;
  c->carried = chain_sum(c, back) * chain_squared(cosine);
  c->pdf = pdf;
  c->sharp = sharp;
}
#endif
