/* Scattering lobes: what a material program leaves behind at a hit, ready to be sampled by render/bsdf.h.
 *
 * The constructors do once per hit what does not depend on the outgoing direction: Fresnel colors, the energy lost between
 * microfacets, and each lobe's share of the samples. The models are those of Blender 4.5's Principled BSDF.
 */
#ifndef BENT_SCENE_CLOSURE_H
#define BENT_SCENE_CLOSURE_H
#include "base/vec3.h"

struct shade_point;

typedef enum closure_kind {
  CLOSURE_DIFFUSE,    /* Lambert; with roughness, energy-preserving Oren-Nayar */
  CLOSURE_SHEEN,      /* fibers that stand on the surface (scene/sheen.h) */
  CLOSURE_VELVET,     /* microfacets that stand upright rather than lie (scene/sheen.h) */
  CLOSURE_REFLECTION, /* GGX reflection; alpha 0: mirror */
  CLOSURE_GLASS,      /* dielectric GGX reflection and refraction; alpha 0: smooth */
  CLOSURE_REFRACTION, /* glass without its reflection and its Fresnel loss */
  CLOSURE_TRANSLUCENT, /* Lambert on the other side */
  CLOSURE_SUBSURFACE, /* into what is inside, to come out elsewhere (render/subsurface.h); counts as a delta lobe */
  CLOSURE_TRANSPARENT /* passes straight on */
} closure_kind;

typedef enum subsurface_method {
  SUBSURFACE_WALK, /* light is refracted into a medium that reflects the lobe's color */
  SUBSURFACE_SKIN  /* the same, but one half of the light enters by a cosine; another scale of the radius */
} subsurface_method;

typedef enum fresnel_kind {
  FRESNEL_NONE,       /* reflects everything (Glossy BSDF: its color is in the weight) */
  FRESNEL_DIELECTRIC, /* unpolarized dielectric */
  FRESNEL_TINTED,     /* the dielectric curve remapped to start at f0 instead of its own value at normal incidence */
  FRESNEL_CONDUCTOR,  /* Schlick from f0 to 1, minus `edge` * mu (1 - mu)^6 (F82 tint) */
  FRESNEL_COMPLEX,    /* conductor of refractive index f0 and extinction coefficient `edge` */
  /* the same under a thin film, from here on: */
  FRESNEL_FILM_ON_TINTED, FRESNEL_FILM_ON_CONDUCTOR, FRESNEL_FILM_ON_COMPLEX
} fresnel_kind;

/* A film so thin that light which it reflects on both sides interferes. */
typedef struct thin_film {
  double thickness, thinnest; /* nm; films thinner than `thinnest` fade into nothing, those below 0.1 nm are none */
  double ior;                 /* relative to the side of wo */
  /* what channels see of light that interferes, by the difference of ways (fresnel_film.c) */
  const float (*sensitivity)[4];
  int count;
  double reach; /* nm: the difference of ways of the last entry */
} thin_film;
static inline int film_exists(const thin_film *film) { return film && film->thickness > 0.1 && film->ior > 0; }

typedef enum facets {
  FACETS_GGX,
  FACETS_MULTI_GGX, /* GGX that makes up for light lost between microfacets */
  FACETS_BECKMANN,
  FACETS_ASHIKHMIN_SHIRLEY /* of Glossy only: not quite microfacets */
} facets;

typedef struct closure {
  closure_kind kind;
  fresnel_kind fresnel;
  facets facets;            /* of microfacets */
  vec3 weight;              /* multiplies the lobe */
  vec3 normal;              /* after normal maps, on the side of wo */
  double share;             /* relative chance of being sampled; the set's shares sum to 1 after closure_set_finish */
  double alpha;             /* microfacets: roughness^2, along the tangent; diffuse: Oren-Nayar roughness in [0, 1] */
  double alpha_y;           /* microfacets: across the tangent */
  vec3 tangent;             /* of sheen and of microfacets that are not a delta: a unit vector at right angles to the normal;
                             * of subsurface: the normal as it was given */
  vec3 wo;                  /* of such microfacets: in the axes tangent, normal x tangent, normal */
  double masking;           /* of such: 1 + Lambda(wo) */
  double sheen_a, sheen_b;  /* sheen: its shape; velvet: a is how upright */
  vec3 radius;              /* subsurface: mean free path of each channel; 0: such light does not get here */
  double anisotropy;        /* subsurface: mean cosine of the angle of one scattering inside, in [0, 0.9] */
  subsurface_method method;
  double ior;               /* of the side beyond the surface relative to the side of wo */
  double energy_scale;      /* makes up for light lost between microfacets; 1 for single scattering */
  vec3 f0, edge;            /* Fresnel colors; of subsurface f0 is the color */
  vec3 transmission_color;  /* glass: tint of what is refracted */
  int no_reflection, no_refraction; /* glass: one of the two is left out */
  vec3 multiscatter;        /* diffuse with roughness: the part of the second bounce that depends on wo only */
  vec3 albedo;              /* estimate, with the weight, for this wo */
  thin_film film;           /* of FRESNEL_FILM_ON_* */
} closure;

typedef struct closure_set {
  int count;
  int delta_count;   /* how many of them are delta lobes */
  closure *closures; /* the caller's, with room for all that the program may add (program.lobe_count) */
  vec3 emission;     /* radiance leaving towards wo */
  vec3 holdout;      /* the part of the surface that is a hole in the picture */
} closure_set;

/* How the roughness depends on the direction along the surface. */
typedef struct stretch {
  double anisotropy; /* 0: not at all */
  double rotation;   /* of the tangent around the normal, in turns */
  vec3 tangent;      /* any vector; if it says no direction along the surface, the roughness is the same all around */
} stretch;

/* Each adds at most one lobe with `weight` (colors >= 0, not finite counts as 0). `normal` may be any vector: a zero or
 * not finite one becomes the point's shading normal. Roughness is Blender's, in [0, 1]. */
void closure_add_diffuse(closure_set *set, const struct shade_point *point, vec3 weight, vec3 color, double roughness,
                         vec3 normal);
void closure_add_glossy(closure_set *set, const struct shade_point *point, vec3 weight, vec3 color, double roughness,
                        vec3 normal, const stretch *stretch, facets facets);
/* Metal of a color from the front and a tint at the edge or, if `physical`, of a refractive index and an extinction. Films
 * may be NULL: none. */
void closure_add_metallic(closure_set *set, const struct shade_point *point, vec3 weight, vec3 color_or_ior,
                          vec3 tint_or_extinction, double roughness, vec3 normal, const stretch *stretch,
                          const thin_film *film, facets facets, int physical);
void closure_add_glass(closure_set *set, const struct shade_point *point, vec3 weight, vec3 color, double roughness,
                       double ior, vec3 normal, const thin_film *film, facets facets);
void closure_add_refraction(closure_set *set, const struct shade_point *point, vec3 weight, vec3 color, double roughness,
                            double ior, vec3 normal, facets facets);
void closure_add_translucent(closure_set *set, const struct shade_point *point, vec3 weight, vec3 color, vec3 normal);
void closure_add_transparent(closure_set *set, vec3 weight);
/* Returns what the lobe takes from the layers below. */
vec3 closure_add_sheen(closure_set *set, const struct shade_point *point, vec3 weight, vec3 color, double roughness,
                       vec3 normal);
void closure_add_velvet(closure_set *set, const struct shade_point *point, vec3 weight, vec3 color, double roughness,
                        vec3 normal);

/* Layers that most Principled BSDFs do without. */
typedef struct sheen_layer {
  double weight, roughness;
  vec3 tint;
} sheen_layer;
typedef struct coat_layer {
  double weight, roughness, ior;
  vec3 tint, normal;
} coat_layer;

/* What is below the surface. `ior` and `alpha` (roughness of the way in, squared) are the Principled BSDF's own there,
 * except for `ior` by SUBSURFACE_SKIN. */
typedef struct subsurface {
  double weight, scale, ior, anisotropy, alpha;
  vec3 radius;
  subsurface_method method;
} subsurface;

/* What comes back from below the surface: channels without a radius as from a diffuse surface. The weight is that of `s`
 * times `weight`. */
void closure_add_subsurface(closure_set *set, const struct shade_point *point, vec3 weight, vec3 color,
                            const subsurface *s, vec3 normal);

typedef struct principled {
  vec3 base_color, normal, specular_tint, emission_color;
  double metallic, roughness, diffuse_roughness, ior, specular_level, transmission, alpha, emission_strength;
  stretch stretch;
  const sheen_layer *sheen; /* NULL: none */
  const coat_layer *coat;
  const subsurface *subsurface;
  const thin_film *film;
  int multiscatter;
} principled;
/* At most: transparent, metal, glass, specular, diffuse; and one for each layer. */
enum { PRINCIPLED_LOBES = 5, SHEEN_LAYER_LOBES = 1, COAT_LAYER_LOBES = 1, SUBSURFACE_LOBES = 2 };
void closure_add_principled(closure_set *set, const struct shade_point *point, vec3 weight, const principled *p);
/* Only the light that it emits, which is what closure_add_principled adds. */
void closure_emit_principled(closure_set *set, const struct shade_point *point, vec3 weight, const principled *p);

/* The single-scattering part of the rough diffuse lobe (without cosine and color), and its albedo. sigma is the roughness;
 * nl, nv, lv: cosines between normal, light and view. */
double closure_oren_nayar_single(double sigma, double nl, double nv, double lv);
double closure_oren_nayar_albedo(double sigma, double cos_n);

/* Makes microfacets at least as rough as `alpha`, after closure_set_finish; all else stays, as in Cycles. */
void closure_set_blur(closure_set *set, const struct shade_point *point, double alpha);
/* Normalizes the shares. Call once after the last add. */
void closure_set_finish(closure_set *set);

/* The smooth limit: below this, in the geometric mean, a microfacet lobe is a delta. Blender's threshold. */
#define CLOSURE_ALPHA_MIN 1.4142135623730951e-5
static inline int closure_is_microfacet(const closure *c)
{
  return c->kind == CLOSURE_REFLECTION || c->kind == CLOSURE_GLASS || c->kind == CLOSURE_REFRACTION;
}
static inline int closure_is_delta(const closure *c)
{
  return c->kind == CLOSURE_TRANSPARENT || c->kind == CLOSURE_SUBSURFACE ||
         (closure_is_microfacet(c) && c->alpha * c->alpha_y <= CLOSURE_ALPHA_MIN * CLOSURE_ALPHA_MIN);
}
#endif
