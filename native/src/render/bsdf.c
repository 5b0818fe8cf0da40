/* Sampling and evaluation of closure sets: lobes are mixed by their shares (one-sample balance heuristic). */
#include "render/bsdf.h"

#include "scene/facets.h"
#include "scene/fresnel.h"
#include "scene/sheen.h"

typedef struct frame {
  vec3 x, y, z;
} frame;

static frame frame_around(vec3 z)
{
  frame f = {.z = z};
  v3_basis(z, &f.x, &f.y);
  return f;
}
/* In which sheen and microfacets are described. */
static frame frame_of(const closure *c)
{
  return (frame){c->tangent, v3_cross(c->normal, c->tangent), c->normal};
}
static vec3 into_frame(const frame *f, vec3 v) { return v3(v3_dot(f->x, v), v3_dot(f->y, v), v3_dot(f->z, v)); }
static vec3 out_of_frame(const frame *f, vec3 v)
{
  return v3_add(v3_add(v3_scale(f->x, v.x), v3_scale(f->y, v.y)), v3_scale(f->z, v.z));
}

/* f |cos| and pdf of one lobe. */
typedef struct lobe_value {
  vec3 value;
  double pdf;
} lobe_value;

/* Softens the terminator of diffuse lobes where a normal map turns the normal away from the smooth one, as Cycles does:
 * Conty et al., "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem" (Ray Tracing Gems, 2019). */
static double bump_shadow(vec3 smooth, vec3 normal, vec3 wi)
{
  const double tilt = v3_dot(smooth, normal), tilt2 = squared(tilt);
  const double in = v3_dot(smooth, wi), in2 = min2(squared(in), 1);
  if (in <= 0 || tilt < 0) return 0; /* a normal that points into the surface scatters nothing */
  const double alpha2 = tilt2 > 0 ? min2(max2(0.125 * (1 - tilt2) / tilt2, 0), 1) : 1;
  return 2 / (1 + sqrt(1 + alpha2 * (1 - in2) / in2));
}

static lobe_value evaluate_diffuse(const closure *c, vec3 wo, vec3 wi)
{
  const double nl = v3_dot(c->normal, wi);
  if (nl <= 0) return (lobe_value){{0, 0, 0}, 0};
  lobe_value out = {v3_splat(nl / MICROFACET_PI), nl / MICROFACET_PI};
  if (c->alpha > 0) {
    const double nv = max2(v3_dot(c->normal, wo), 0);
    const double single = closure_oren_nayar_single(c->alpha, nl, nv, v3_dot(wi, wo));
    const double missed = 1 - closure_oren_nayar_albedo(c->alpha, nl);
    out.value = v3_scale(v3_add(v3_splat(single), v3_scale(c->multiscatter, missed)), nl);
  }
  return out;
}

static lobe_value evaluate_translucent(const closure *c, vec3 wi)
{
  const double value = max2(-v3_dot(c->normal, wi), 0) / MICROFACET_PI;
  return (lobe_value){v3_splat(value), value};
}

static lobe_value evaluate_sheen(const closure *c, vec3 wi)
{
  const frame f = frame_of(c);
  const vec3 w = into_frame(&f, wi);
  const double value = w.z > 0 ? sheen_density(c->sheen_a, c->sheen_b, w) : 0;
  return (lobe_value){v3_splat(value), value};
}

static lobe_value evaluate_velvet(const closure *c, vec3 wo, vec3 wi)
{
  const frame f = frame_around(c->normal);
  const vec3 out = into_frame(&f, wo), in = into_frame(&f, wi);
  if (out.z <= 0 || in.z <= 0) return (lobe_value){{0, 0, 0}, 0};
  return (lobe_value){v3_splat(velvet_value(c->sheen_a, out, in)), 0.5 / MICROFACET_PI};
}

static lobe_value evaluate_ashikhmin(const closure *c, vec3 wi)
{
  if (c->wo.z <= 0 || wi.z <= 0) return (lobe_value){{0, 0, 0}, 0};
  double pdf;
  const double value = ashikhmin_value(c, wi, &pdf);
  return (lobe_value){v3_splat(value), pdf};
}

/* wi in the lobe's frame. Walter et al. (2007), equations 20, 21 and 41. */
static inline __attribute__((always_inline)) lobe_value evaluate_facets(const closure *c, vec3 wi, int is_beckmann)
{
  const vec3 wo = c->wo;
  lobe_value out = {{0, 0, 0}, 0};
  const int through = wi.z < 0;
  if (wo.z <= 0 || wi.z == 0 || (through && c->kind == CLOSURE_REFLECTION)) return out;
  vec3 h = through ? v3_mad(wi, c->ior, wo) : v3_add(wo, wi);
  const double length = v3_length(h);
  if (length < 1e-12) return out;
  h = v3_scale(h, (h.z < 0 ? -1 : 1) / length);
  const double cos_i = min2(v3_dot(wo, h), 1), cos_o = v3_dot(wi, h);
  if (cos_i <= 0 || (through ? cos_o >= 0 : cos_o <= 0)) return out;
  vec3 reflected, transmitted;
  double cos_t;
  fresnel_colors(c, cos_i, &reflected, &transmitted, &cos_t);
  const double r = v3_average(reflected), t = v3_average(transmitted);
  if (r + t <= 0) return out;
  const double lambda =
      is_beckmann ? beckmann_lambda(wi, c->alpha, c->alpha_y) : ggx_lambda(wi, c->alpha, c->alpha_y);
  const double density =
      is_beckmann ? beckmann_density(h, c->alpha, c->alpha_y) : ggx_density(h, c->alpha, c->alpha_y);
  const double jacobian = through ? squared(c->ior / length) * fabs(cos_o) * cos_i : 0.25;
  const double seen = density * jacobian / wo.z;
  out.pdf = seen / c->masking;
  if (c->kind == CLOSURE_GLASS) out.pdf *= (through ? t : r) / (r + t);
  out.value = v3_scale(through ? transmitted : reflected, seen / (c->masking + lambda) * c->energy_scale);
  return out;
}

/* GGX is what nearly all are. */
static __attribute__((noinline)) lobe_value evaluate_rare_facets(const closure *c, vec3 wi)
{
  return c->facets == FACETS_BECKMANN ? evaluate_facets(c, wi, 1) : evaluate_ashikhmin(c, wi);
}

/* Of the lobes that reflect. */
static int is_diffuse(const closure *c) { return c->kind == CLOSURE_DIFFUSE || c->kind == CLOSURE_SHEEN; }

/* The rarer lobes, out of the way of the others. */
static __attribute__((noinline)) lobe_value evaluate_rare(const closure *c, vec3 wo, vec3 wi)
{
  if (c->kind == CLOSURE_SHEEN) return evaluate_sheen(c, wi);
  if (c->kind == CLOSURE_VELVET) return evaluate_velvet(c, wo, wi);
  return evaluate_translucent(c, wi);
}

static lobe_value evaluate_lobe(const closure *c, const shade_point *point, vec3 wi)
{
  const int through = v3_dot(point->geometric_normal, wi) < 0;
  if (through != (v3_dot(c->normal, wi) < 0)) return (lobe_value){{0, 0, 0}, 0}; /* would leak through the surface */
  lobe_value out;
  if (c->kind == CLOSURE_DIFFUSE) {
    out = evaluate_diffuse(c, point->wo, wi);
  } else if (closure_is_microfacet(c)) {
    const frame f = frame_of(c);
    const vec3 in = into_frame(&f, wi);
    out = c->facets < FACETS_BECKMANN ? evaluate_facets(c, in, 0) : evaluate_rare_facets(c, in);
  } else {
    out = evaluate_rare(c, point->wo, wi);
  }
  if (!through && is_diffuse(c) && v3_dot(c->normal, point->normal) < 1 - 1e-9)
    out.value = v3_scale(out.value, bump_shadow(point->normal, c->normal, wi));
  out.value = v3_mul(out.value, c->weight);
  return out;
}

static bsdf_lobe kind_of(const closure *c, const shade_point *point, vec3 wi)
{
  if (v3_dot(point->geometric_normal, wi) < 0) return LOBE_TRANSMISSION;
  return is_diffuse(c) ? LOBE_DIFFUSE : LOBE_GLOSSY;
}

vec3 bsdf_evaluate(const closure_set *set, const shade_point *point, vec3 wi, uint32_t kinds, double *pdf)
{
  vec3 sum = v3(0, 0, 0);
  *pdf = 0;
  for (int i = 0; i < set->count; i++) {
    const closure *c = &set->closures[i];
    if (closure_is_delta(c)) continue;
    const lobe_value lobe = evaluate_lobe(c, point, wi);
    if (kinds & kind_of(c, point, wi)) sum = v3_add(sum, lobe.value);
    *pdf += lobe.pdf * c->share;
  }
  return sum;
}

int bsdf_is_diffuse_part(const closure *c)
{
  return is_diffuse(c) || c->kind == CLOSURE_TRANSLUCENT || c->kind == CLOSURE_SUBSURFACE;
}

bsdf_parts bsdf_evaluate_parts(const closure_set *set, const shade_point *point, vec3 wi, uint32_t kinds)
{
  bsdf_parts sum = {.all = {0, 0, 0}};
  for (int i = 0; i < set->count; i++) {
    const closure *c = &set->closures[i];
    if (closure_is_delta(c) || !(kinds & kind_of(c, point, wi))) continue;
    const vec3 value = evaluate_lobe(c, point, wi).value;
    sum.all = v3_add(sum.all, value);
    if (bsdf_is_diffuse_part(c)) sum.diffuse = v3_add(sum.diffuse, value);
    else if (kind_of(c, point, wi) == LOBE_GLOSSY) sum.glossy = v3_add(sum.glossy, value);
  }
  return sum;
}

/* Of the two ways of smooth glass, one that takes less than this part of the light is drawn more often than that. */
static const double FAINT_PART = 0.1;
static const double FAINT_FAVOR = 2.5;

/* The chance with which smooth glass that reflects r and refracts t is drawn to reflect.
 *
 * A way of part R that is drawn with chance p brings R^2 / p times the second moment of what is seen by it. With p = R few
 * samples bring the whole light of a lamp that glass mirrors faintly: no connection finds it, and it may be most of a
 * picture's noise. Favored, it is up to 2.5 times less. Where both ways see equally bright things the noise grows, by 4 %
 * at most: R / 2.5 + (1 - R)^2 / (1 - 2.5 R) at R = 0.04. */
static double reflection_chance(double r, double t)
{
  const double part = r / (r + t), faint = min2(part, 1 - part);
  const double favored = max2(faint, min2(FAINT_FAVOR * faint, FAINT_PART));
  return part < 0.5 ? favored : 1 - favored;
}

/* Mirror, smooth glass or transparent: the weight without the lobe's share. */
static int draw_delta(const closure *c, const shade_point *point, double u, bsdf_sample *out)
{
  out->pdf = 0;
  if (c->kind == CLOSURE_TRANSPARENT) {
    out->wi = v3_scale(point->wo, -1);
    out->weight = c->weight;
    out->lobe = LOBE_TRANSPARENT;
    return 1;
  }
  const double cos_i = min2(v3_dot(c->normal, point->wo), 1);
  if (cos_i <= 0) return 0;
  vec3 reflected, transmitted;
  double cos_t;
  fresnel_colors(c, cos_i, &reflected, &transmitted, &cos_t);
  const double r = v3_average(reflected), t = v3_average(transmitted);
  if (r + t <= 0) return 0;
  const double reflects = reflection_chance(r, t);
  const int through = u >= reflects && t > 0;
  const double chance = through ? 1 - reflects : reflects;
  out->wi = v3_normalize(through ? refract(point->wo, c->normal, cos_i, cos_t, c->ior) : reflect(point->wo, c->normal));
  out->lobe = through ? LOBE_TRANSMISSION : LOBE_GLOSSY;
  out->weight = v3_mul(c->weight, v3_scale(through ? transmitted : reflected, 1 / chance));
  return (v3_dot(out->wi, point->geometric_normal) < 0) == through;
}

/* A direction from a lobe that is not of microfacets: a cosine, what is made of one, or all directions alike. */
static void draw_cosine(const closure *c, double u0, double u1, bsdf_sample *out)
{
  const frame f = c->kind == CLOSURE_SHEEN ? frame_of(c) : frame_around(c->normal);
  const int through = c->kind == CLOSURE_TRANSLUCENT, uniform = c->kind == CLOSURE_VELVET;
  const double r = sqrt(uniform ? u0 * (2 - u0) : u0), z = uniform ? 1 - u0 : sqrt(max2(1 - u0, 0));
  double sine, cosine;
  turn_sincos(u1, &sine, &cosine);
  vec3 w = v3(r * cosine, r * sine, through ? -z : z);
  if (c->kind == CLOSURE_SHEEN) w = sheen_direction(c->sheen_a, c->sheen_b, w);
  out->wi = out_of_frame(&f, w);
  out->lobe = through ? LOBE_TRANSMISSION : is_diffuse(c) ? LOBE_DIFFUSE : LOBE_GLOSSY;
}

/* The way of light into what is below the surface: through a microfacet, nothing lost; or by a cosine. */
static int draw_entry(const closure *c, const shade_point *point, double u0, double u1, double u2, bsdf_sample *out)
{
  const frame f = frame_around(c->normal);
  const vec3 wo = into_frame(&f, point->wo);
  out->pdf = 0;
  out->lobe = LOBE_SUBSURFACE;
  out->entered = c;
  out->weight = c->weight;
  vec3 w;
  if (c->method == SUBSURFACE_SKIN && u2 < 0.5) {
    double sine, cosine;
    turn_sincos(u1, &sine, &cosine);
    w = v3(sqrt(u0) * cosine, sqrt(u0) * sine, -sqrt(max2(1 - u0, 0)));
  } else {
    if (wo.z <= 0) return 0;
    const vec3 h = ggx_sample_visible(wo, c->alpha, c->alpha, u0, u1);
    const double cos_i = min2(v3_dot(wo, h), 1);
    double cos_t;
    if (cos_i <= 0 || fresnel_dielectric(cos_i, c->ior, &cos_t) >= 1) return 0;
    w = refract(wo, h, cos_i, cos_t, c->ior);
  }
  out->wi = v3_normalize(out_of_frame(&f, w));
  return v3_dot(out->wi, point->geometric_normal) < 0;
}

/* A direction from one rough lobe. */
static int draw_rough(const closure *c, double u0, double u1, double u2, bsdf_sample *out)
{
  if (!closure_is_microfacet(c)) {
    draw_cosine(c, u0, u1, out);
    return 1;
  }
  const frame f = frame_of(c);
  const vec3 wo = c->wo;
  if (wo.z <= 0) return 0;
  const vec3 h = c->facets == FACETS_ASHIKHMIN_SHIRLEY ? ashikhmin_sample(c, u0, u1) : facets_sample_visible(c, u0, u1);
  const double cos_i = min2(v3_dot(wo, h), 1);
  if (cos_i <= 0) return 0;
  vec3 reflected, transmitted;
  double cos_t;
  fresnel_colors(c, cos_i, &reflected, &transmitted, &cos_t);
  const double r = v3_average(reflected), t = v3_average(transmitted), pick = u2 * (r + t);
  const int through = pick >= r && t > 0;
  const vec3 wi = through ? refract(wo, h, cos_i, cos_t, c->ior) : reflect(wo, h);
  if (r + t <= 0 || (wi.z < 0) != through) return 0;
  out->wi = v3_normalize(out_of_frame(&f, wi));
  out->lobe = through ? LOBE_TRANSMISSION : LOBE_GLOSSY;
  return 1;
}

int bsdf_draw(const closure_set *set, const shade_point *point, const double u[3], bsdf_sample *out)
{
  double rest = u[2];
  int chosen = -1;
  for (int i = 0; i < set->count; i++) {
    const double share = set->closures[i].share;
    if (!(share > 0)) continue;
    chosen = i;
    if (rest < share) break;
    rest -= share;
  }
  if (chosen < 0) return 0;
  const closure *c = &set->closures[chosen];
  rest = min2(max2(rest / c->share, 0), 1 - 1e-9); /* again uniform in [0, 1) */
  if (closure_is_delta(c)) {
    if (!(c->kind == CLOSURE_SUBSURFACE ? draw_entry(c, point, u[0], u[1], rest, out) : draw_delta(c, point, rest, out)))
      return 0;
    out->weight = v3_scale(out->weight, 1 / c->share);
    return 1;
  }
  if (!draw_rough(c, u[0], u[1], rest, out)) return 0;
  const vec3 value = bsdf_evaluate(set, point, out->wi, UINT32_MAX, &out->pdf);
  if (!(out->pdf > 0) || !isfinite(out->pdf)) return 0;
  out->weight = v3_scale(value, 1 / out->pdf);
  return v3_max(out->weight) > 0;
}

int bsdf_drawn(const closure_set *set, const shade_point *point, vec3 wi, double u, bsdf_sample *out)
{
  vec3 value = v3(0, 0, 0);
  *out = (bsdf_sample){.wi = wi};
  double chance[LOBE_TRANSMISSION + 1] = {0}; /* by kind */
  for (int i = 0; i < set->count; i++) {
    const closure *c = &set->closures[i];
    if (closure_is_delta(c)) continue;
    const lobe_value lobe = evaluate_lobe(c, point, wi);
    value = v3_add(value, lobe.value);
    out->pdf += lobe.pdf * c->share;
    chance[kind_of(c, point, wi)] += lobe.pdf * c->share;
  }
  if (!(out->pdf > 0) || !isfinite(out->pdf)) return 0;
  double rest = u * out->pdf;
  for (int kind = LOBE_DIFFUSE; kind <= LOBE_TRANSMISSION; rest -= chance[kind], kind *= 2)
    if (chance[kind] > 0 && (out->lobe == 0 || rest >= 0)) out->lobe = (bsdf_lobe)kind;
  out->weight = v3_scale(value, 1 / out->pdf);
  return v3_max(out->weight) > 0;
}

/* Directions of mirror rays that differ by less are the same. */
static const double SHARP_APART = 1e-5;

bsdf_sharp bsdf_evaluate_sharp(const closure_set *set, const shade_point *point, vec3 wi)
{
  bsdf_sharp out = {.through = v3_dot(wi, point->geometric_normal) < 0};
  for (int i = 0; i < set->count; i++) {
    const closure *c = &set->closures[i];
    if (!closure_is_delta(c) || !closure_is_microfacet(c)) continue;
    const double cos_i = min2(v3_dot(c->normal, point->wo), 1);
    if (cos_i <= 0) continue;
    vec3 reflected, transmitted;
    double cos_t;
    fresnel_colors(c, cos_i, &reflected, &transmitted, &cos_t);
    const double r = v3_average(reflected), t = v3_average(transmitted), part = out.through ? t : r;
    if (!(part > 0)) continue;
    const vec3 drawn = out.through ? refract(point->wo, c->normal, cos_i, cos_t, c->ior) : reflect(point->wo, c->normal);
    if (v3_length(v3_sub(v3_normalize(drawn), wi)) > SHARP_APART) continue;
    const vec3 value = v3_mul(c->weight, out.through ? transmitted : reflected);
    const double reflects = reflection_chance(r, t);
    out.chance += c->share * (out.through ? 1 - reflects : reflects);
    out.value = v3_add(out.value, value);
    const double widened = out.through ? squared(c->ior) * fabs(v3_dot(c->normal, wi)) / cos_i : 1;
    out.flux = v3_mad(value, widened, out.flux);
  }
  return out;
}

vec3 bsdf_transparency(const closure_set *set, double *chance)
{
  vec3 sum = v3(0, 0, 0);
  *chance = 0;
  for (int i = 0; i < set->count; i++) {
    if (set->closures[i].kind != CLOSURE_TRANSPARENT) continue;
    sum = v3_add(sum, set->closures[i].weight);
    *chance += set->closures[i].share;
  }
  return sum;
}

vec3 bsdf_kind_weight(const closure_set *set, const shade_point *point, const bsdf_sample *drawn)
{
  vec3 all = v3(0, 0, 0), own = all;
  double all_pdf = 0, own_pdf = 0;
  for (int i = 0; drawn->pdf > 0 && i < set->count; i++) {
    const closure *c = &set->closures[i];
    if (closure_is_delta(c)) continue;
    const lobe_value lobe = evaluate_lobe(c, point, drawn->wi);
    const int is_own = kind_of(c, point, drawn->wi) == drawn->lobe;
    all = v3_add(all, lobe.value), all_pdf += lobe.pdf * c->share;
    if (is_own) own = v3_add(own, lobe.value), own_pdf += lobe.pdf * c->share;
  }
  if (!(own_pdf > 0)) return v3_splat(1);
  const double rarity = all_pdf / own_pdf;
  return v3(all.x > 0 ? own.x / all.x * rarity : 1, all.y > 0 ? own.y / all.y * rarity : 1,
            all.z > 0 ? own.z / all.z * rarity : 1);
}

uint32_t bsdf_ray_kinds(const closure_set *set, bsdf_lobe lobe)
{
  if (lobe == LOBE_DIFFUSE) return RAY_DIFFUSE | RAY_REFLECTION;
  if (lobe == LOBE_GLOSSY) return RAY_GLOSSY | RAY_REFLECTION;
  for (int i = 0; i < set->count; i++)
    if (set->closures[i].kind == CLOSURE_TRANSLUCENT) return RAY_DIFFUSE | RAY_TRANSMISSION;
  return RAY_GLOSSY | RAY_TRANSMISSION;
}

void bsdf_albedo_parts(const closure *c, const shade_point *point, vec3 *reflected, vec3 *transmitted)
{
  *reflected = c->albedo, *transmitted = v3(0, 0, 0);
  if (c->kind != CLOSURE_GLASS && c->kind != CLOSURE_REFRACTION) return;
  vec3 r, t;
  double cos_t;
  fresnel_colors(c, min2(max2(v3_dot(c->normal, point->wo), 0), 1), &r, &t, &cos_t);
  const vec3 all = v3_add(r, t);
  *reflected = v3(all.x > 0 ? c->albedo.x * r.x / all.x : 0, all.y > 0 ? c->albedo.y * r.y / all.y : 0,
                  all.z > 0 ? c->albedo.z * r.z / all.z : 0);
  *transmitted = v3_sub(c->albedo, *reflected);
}

vec3 bsdf_albedo(const closure_set *set)
{
  vec3 sum = v3(0, 0, 0);
  for (int i = 0; i < set->count; i++) {
    const closure *c = &set->closures[i];
    const int is_clear = closure_is_delta(c) && c->kind != CLOSURE_SUBSURFACE;
    sum = v3_add(sum, is_clear ? v3_splat(v3_average(c->weight)) : c->albedo);
  }
  return v3_saturate(sum);
}
