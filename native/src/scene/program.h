/* The register machine that runs a compiled node tree once per hit.
 *
 * To add a node: one row in PROGRAM_OPS, one function op_<name> in a program_*.c file, and one compile function in the host
 * (which finds the number of the operation by its name). Instructions whose operands are all constants are run once when
 * the program is made, if their row says PURE.
 */
#ifndef BENT_SCENE_PROGRAM_H
#define BENT_SCENE_PROGRAM_H
#include "scene/shading.h"
#include "scene/texture.h"

enum { PROGRAM_REGISTERS = 1024, OPERANDS_MAX = 16 };

/* Layers that operations have put aside for the next one that takes them. */
typedef struct program_layers {
  int has_sheen, has_coat, has_subsurface, has_film;
  sheen_layer sheen;
  coat_layer coat;
  subsurface subsurface;
  thin_film film;
} program_layers;

/* What an operation sees besides its operands. */
typedef struct program_context {
  const shade_point *point;
  const image *images;
  const float (*table)[4];
  closure_set *set;
  program_layers *layers;
  int emission_only; /* scattering lobes are not wanted */
} program_context;

/* Reads in[0 ...], writes out[0 ...]; the counts are those of its row. */
typedef void operation(const program_context *context, const vec3 *const *in, const int32_t *immediates, vec3 *out);

typedef struct program {
  int32_t *code;
  vec3 *constants;
  float (*table)[4];
  size_t code_length, constant_count, table_length;
  int may_be_transparent, may_emit;
  int asks_scattering; /* by what kind of scattering the ray came */
  int asks_length;     /* how long the ray is */
  int asks_tangent;    /* how the texture's axes lie on the surface */
  int asks_history;    /* anything about the ray's way to the surface, its length too if it scatters there */
  int asks_frequency;  /* how the ray's frequency is shifted */
  int lobe_count; /* most lobes that one run can add */
  int emits_evenly; /* the same everywhere, to all sides */
  vec3 emission;    /* if so */
} program;

/* Checks and copies; `image_count` images exist. Frees what `out` held before only if it succeeds. */
bent_status program_make(program *out, const bent_program *source, int image_count, bent_error *error);
void program_free(program *program);
/* The image of the first equirectangular environment in the instructions from *at on, 0 at first, which is moved behind it; -1:
 * there are no more. */
int program_next_sky_image(const program *program, size_t *at);
/* Runs the program; context->table and layers are set by it, and closures are added to context->set. */
void program_run(const program *program, program_context *context);

/* Names of the values of an immediate, as Blender spells them; NULL at the end. */
#define MATH_OPERATIONS(X)                                                                                             \
  X(ADD) X(SUBTRACT) X(MULTIPLY) X(DIVIDE) X(MULTIPLY_ADD) X(POWER) X(LOGARITHM) X(SQRT) X(INVERSE_SQRT) X(ABSOLUTE)   \
  X(EXPONENT) X(MINIMUM) X(MAXIMUM) X(LESS_THAN) X(GREATER_THAN) X(SIGN) X(COMPARE) X(SMOOTH_MIN) X(SMOOTH_MAX)        \
  X(ROUND) X(FLOOR) X(CEIL) X(TRUNC) X(FRACT) X(MODULO) X(FLOORED_MODULO) X(WRAP) X(SNAP) X(PINGPONG) X(SINE)          \
  X(COSINE) X(TANGENT) X(ARCSINE) X(ARCCOSINE) X(ARCTANGENT) X(ARCTAN2) X(SINH) X(COSH) X(TANH) X(RADIANS) X(DEGREES)
#define BLEND_TYPES(X)                                                                                                 \
  X(MIX) X(DARKEN) X(MULTIPLY) X(BURN) X(LIGHTEN) X(SCREEN) X(DODGE) X(ADD) X(OVERLAY) X(SOFT_LIGHT) X(LINEAR_LIGHT)   \
  X(DIFFERENCE) X(EXCLUSION) X(SUBTRACT) X(DIVIDE) X(HUE) X(SATURATION) X(COLOR) X(VALUE)
#define VECTOR_OPERATIONS(X)                                                                                           \
  X(ADD) X(SUBTRACT) X(MULTIPLY) X(DIVIDE) X(MULTIPLY_ADD) X(CROSS_PRODUCT) X(PROJECT) X(REFLECT) X(REFRACT)           \
  X(FACEFORWARD) X(DOT_PRODUCT) X(DISTANCE) X(LENGTH) X(SCALE) X(NORMALIZE) X(ABSOLUTE) X(POWER) X(SIGN) X(MINIMUM)    \
  X(MAXIMUM) X(FLOOR) X(CEIL) X(FRACTION) X(MODULO) X(WRAP) X(SNAP) X(SINE) X(COSINE) X(TANGENT)
#define MAP_INTERPOLATIONS(X) X(LINEAR) X(STEPPED) X(SMOOTHSTEP) X(SMOOTHERSTEP)
#define CLAMP_TYPES(X) X(MINMAX) X(RANGE)
#define COLOR_MODELS(X) X(HSV) X(HSL)
#define COORDINATES(X) X(UV) X(GENERATED) X(OBJECT) X(NORMAL) X(REFLECTION) X(POSITION) X(SHADING_NORMAL)  \
  X(TRUE_NORMAL) X(TANGENT) X(INCOMING) X(PARAMETRIC) X(BACKFACING) X(OBJECT_LOCATION) X(OBJECT_COLOR) X(OBJECT_ALPHA) \
  X(OBJECT_INDEX) X(OBJECT_RANDOM) X(RAY_LENGTH) X(BEAM)
/* What the Light Path node tells. Those from IS_DIFFUSE on depend on how the ray was scattered, if at all. */
#define LIGHT_PATHS(X)                                                                                                 \
  X(IS_CAMERA) X(IS_SHADOW) X(RAY_DEPTH) X(TRANSPARENT_DEPTH) X(IS_DIFFUSE) X(IS_GLOSSY) X(IS_SINGULAR)                \
  X(IS_REFLECTION) X(IS_TRANSMISSION) X(DIFFUSE_DEPTH) X(GLOSSY_DEPTH) X(TRANSMISSION_DEPTH)
#define MAPPING_TYPES(X) X(POINT) X(TEXTURE) X(VECTOR) X(NORMAL)
#define VECTOR_TYPES(X) X(POINT) X(VECTOR) X(NORMAL)
#define SPACES(X) X(WORLD) X(OBJECT)
#define EXTENSIONS(X) X(REPEAT) X(EXTEND) X(CLIP) X(MIRROR)
#define INTERPOLATIONS(X) X(Linear) X(Closest) X(Cubic) X(Smart)
#define PROJECTIONS(X) X(FLAT) X(SPHERE) X(TUBE)
#define ENVIRONMENT_PROJECTIONS(X) X(EQUIRECTANGULAR) X(MIRROR_BALL)
#define NORMAL_SPACES(X) X(TANGENT) X(OBJECT) X(WORLD) X(BLENDER_OBJECT) X(BLENDER_WORLD)
/* In the order of facets (scene/closure.h). */
#define DISTRIBUTIONS(X) X(GGX) X(MULTI_GGX)
#define FACET_DISTRIBUTIONS(X) DISTRIBUTIONS(X) X(BECKMANN)
#define GLOSSY_DISTRIBUTIONS(X) FACET_DISTRIBUTIONS(X) X(ASHIKHMIN_SHIRLEY)
#define REFRACTION_DISTRIBUTIONS(X) X(GGX) X(BECKMANN)
#define CONDUCTORS(X) X(F82) X(PHYSICAL_CONDUCTOR)
#define SUBSURFACE_METHODS(X) X(RANDOM_WALK) X(RANDOM_WALK_SKIN)
#define SHEEN_MODELS(X) X(ASHIKHMIN) X(MICROFIBER)
#define DIMENSIONS(X) X(1D) X(2D) X(3D) X(4D)
#define FRACTAL_TYPES(X) X(MULTIFRACTAL) X(RIDGED_MULTIFRACTAL) X(HYBRID_MULTIFRACTAL) X(FBM) X(HETERO_TERRAIN)
#define VORONOI_FEATURES(X) X(F1) X(F2) X(SMOOTH_F1) X(DISTANCE_TO_EDGE) X(N_SPHERE_RADIUS)
#define VORONOI_METRICS(X) X(EUCLIDEAN) X(MANHATTAN) X(CHEBYCHEV) X(MINKOWSKI)
#define GABOR_TYPES(X) X(2D) X(3D)
#define GRADIENT_TYPES(X) X(LINEAR) X(QUADRATIC) X(EASING) X(DIAGONAL) X(SPHERICAL) X(QUADRATIC_SPHERE) X(RADIAL)
#define WAVE_TYPES(X) X(BANDS) X(RINGS)
#define WAVE_DIRECTIONS(N) N(X) N(Y) N(Z) N(DIAGONAL) N(SPHERICAL)
#define WAVE_PROFILES(X) X(SIN) X(SAW) X(TRI)
#define DEPTHS(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10)
#define CHANNELS(N) N(X) N(Y) N(Z)
#define SIDES(N) N(X) N(Y)
#define SWITCH(X) X(OFF) X(ON)
#define CHARTS(X) X(ISOTROPIC) X(OBLATE)

/* name, outputs, operands, kind, names of each immediate (NAMES(list), or what it is a number of) */
#define PROGRAM_OPS(OP)                                                                                                \
  OP(coordinate, 1, 0, PER_POINT, NAMES(COORDINATES))                                                                  \
  OP(attribute, 3, 0, PER_POINT, attribute_id) /* -> vector, number, alpha */                                          \
  OP(coordinate_beside, 1, 1, PER_POINT, NAMES(COORDINATES), NAMES(SIDES)) /* filter width */                          \
  OP(attribute_beside, 3, 1, PER_POINT, attribute_id, NAMES(SIDES)) /* filter width -> as attribute */                 \
  /* strength, distance, height here, beside it in X, in Y, filter width, normal; inverted */                          \
  OP(bump, 1, 7, PER_POINT, NAMES(SWITCH))                                                                             \
  OP(light_path, 1, 0, PER_POINT, NAMES(LIGHT_PATHS))                                                                  \
  OP(dot, 1, 2, PURE, NONE)                                                                                            \
  OP(average, 1, 1, PURE, NONE)      /* vector -> float */                                                             \
  OP(channel, 1, 1, PURE, NAMES(CHANNELS))                                                                             \
  OP(combine, 1, 3, PURE, NONE)                                                                                        \
  OP(clamp, 1, 1, PURE, NONE)        /* to [0, 1] */                                                                   \
  OP(math, 1, 3, PURE, NAMES(MATH_OPERATIONS))                                                                         \
  OP(mix, 1, 3, PURE, NONE)          /* factor (per component), a, b */                                                \
  OP(blend, 1, 3, PURE, NAMES(BLEND_TYPES)) /* factor, a, b */                                                         \
  OP(clamp_between, 1, 3, PURE, NAMES(CLAMP_TYPES)) /* value, minimum, maximum */                                      \
  OP(map_range, 1, 6, PURE, NAMES(MAP_INTERPOLATIONS), NAMES(SWITCH)) /* value, from a, b, to a, b, steps; vector */   \
  OP(vector_math, 1, 4, PURE, NAMES(VECTOR_OPERATIONS)) /* a, b, c, scale */                                           \
  OP(color_to_model, 1, 1, PURE, NAMES(COLOR_MODELS))                                                                  \
  OP(color_from_model, 1, 1, PURE, NAMES(COLOR_MODELS))                                                                \
  OP(gamma, 1, 2, PURE, NONE)        /* color, exponent */                                                             \
  OP(invert, 1, 2, PURE, NONE)       /* factor, color */                                                               \
  OP(brightness_contrast, 1, 3, PURE, NONE) /* color, brightness, contrast */                                          \
  OP(hue_saturation, 1, 5, PURE, NONE) /* hue, saturation, value, factor, color */                                     \
  OP(curves, 1, 4, PURE, table_start, table_count, NAMES(SWITCH)) /* factor, color, start, width; extrapolate */       \
  OP(blackbody, 1, 1, PURE, NONE)    /* temperature in K */                                                            \
  OP(multiply, 1, 2, PURE, NONE)                                                                                       \
  OP(transform, 1, 5, PURE, NONE)    /* vector; three columns, translation */                                          \
  OP(mapping, 1, 4, PURE, NAMES(MAPPING_TYPES)) /* vector, location, rotation, scale */                                \
  OP(rotate, 1, 4, PURE, NONE)       /* vector, center, axis, angle */                                                 \
  OP(change_space, 1, 1, PER_POINT, NAMES(VECTOR_TYPES), NAMES(SPACES), NAMES(SPACES)) /* what it is; from, to */      \
  OP(normal_map, 1, 2, PER_POINT, NAMES(NORMAL_SPACES)) /* strength, color */                                          \
  OP(normal_map_along, 1, 4, PER_POINT, NONE) /* strength, color, tangent of the object, its sign */                   \
  OP(tangent, 1, 1, PER_POINT, NONE) /* normal of the object that it is to be along -> tangent of the surface */       \
  OP(fresnel, 1, 2, PER_POINT, NONE) /* ior, normal */                                                                 \
  OP(layer_weight, 2, 2, PER_POINT, NONE) /* blend, normal -> fresnel, facing */                                       \
  OP(checker, 2, 4, PURE, NONE)      /* vector, color 1, color 2, scale -> color, factor */                            \
  /* vector, w, scale, detail, roughness, lacunarity, offset, gain, distortion -> value, color; normalize, color wanted */ \
  OP(noise, 2, 9, PURE, NAMES(DIMENSIONS), NAMES(FRACTAL_TYPES), NAMES(SWITCH), NAMES(SWITCH))                         \
  OP(white_noise, 2, 2, PURE, NAMES(DIMENSIONS)) /* vector, w -> value, color */                                       \
  /* vector, w, scale, detail, roughness, lacunarity, smoothness, exponent, randomness -> distance or radius, color,  \
   * position, w; normalize, cells as before Blender 5.0 */                                                            \
  OP(voronoi, 4, 9, PURE, NAMES(DIMENSIONS), NAMES(VORONOI_FEATURES), NAMES(VORONOI_METRICS), NAMES(SWITCH),           \
     NAMES(SWITCH))                                                                                                    \
  OP(gradient, 1, 1, PURE, NAMES(GRADIENT_TYPES)) /* vector */                                                         \
  /* vector, scale, frequency, anisotropy, angle, orientation -> value, phase, intensity */                             \
  OP(gabor, 3, 6, PURE, NAMES(GABOR_TYPES))                                                                            \
  OP(ies, 1, 1, PURE, table_start, table_count) /* vector */                                                           \
  /* normal, distance -> the part that is open; inside, only this object */                                            \
  OP(occlusion, 1, 2, PER_POINT, ray_count, NAMES(SWITCH), NAMES(SWITCH))                                              \
  OP(magic, 2, 3, PURE, NAMES(DEPTHS)) /* vector, scale, distortion -> color, factor */                                \
  /* vector, scale, distortion, detail, detail scale, detail roughness, phase */                                       \
  OP(wave, 1, 7, PURE, NAMES(WAVE_TYPES), NAMES(WAVE_DIRECTIONS), NAMES(WAVE_PROFILES))                                \
  /* vector, color 1, color 2, mortar, scale, mortar size, mortar smooth, bias, brick width, row height, offset, its  \
   * frequency, squash, its frequency -> color, mortar */                                                              \
  OP(brick, 2, 14, PURE, NONE)                                                                                         \
  OP(ramp, 2, 1, PURE, table_start, table_count, NAMES(SWITCH)) /* factor -> color, alpha; smooth */                  \
  OP(image, 2, 1, PER_POINT, image_index, NAMES(INTERPOLATIONS), NAMES(EXTENSIONS), NAMES(SWITCH)) /* straight alpha */ \
  /* as image, but of tiles that follow each other in the list of images; their UDIM numbers are in the table */         \
  OP(image_tiles, 2, 1, PER_POINT, image_index, table_start, tile_count, NAMES(INTERPOLATIONS), NAMES(EXTENSIONS),     \
     NAMES(SWITCH))                                                                                                    \
  OP(project, 1, 1, PURE, NAMES(PROJECTIONS)) /* vector -> image coordinates */                                        \
  /* vector, the same beside the point in X, in Y (of no use but in a world) */                                        \
  OP(environment, 2, 3, PER_POINT, image_index, NAMES(INTERPOLATIONS), NAMES(ENVIRONMENT_PROJECTIONS))                 \
  OP(sun_disk, 1, 3, PURE, NONE)     /* vector, direction of the sun, half its angle -> 1 in its middle, 0 outside */    \
  OP(sphere_lamp, 1, 1, PER_POINT, NAMES(SWITCH)) /* radius -> 1 where it shines, else 0; soft */                       \
  OP(spot_cone, 1, 3, PER_POINT, NONE) /* cosine of the edge, to full strength, radius -> part of the light */          \
  OP(area_spread, 1, 2, PER_POINT, NONE) /* tangent of the edge, strength -> part of the light */                      \
  OP(light_falloff, 3, 2, PER_POINT, NONE) /* strength, smoothing -> quadratic, linear, constant */                    \
  /* mass, spin over mass -> radius over mass, azimuth, Doppler factor, gravitational factor, image order */             \
  OP(disk, 5, 2, PER_POINT, NAMES(CHARTS))                                                                             \
  OP(disk_flux, 1, 2, PURE, NONE)    /* radius over mass, spin over mass */                                            \
  /* radius over mass, azimuth, spin over mass, phase, period, scale, contrast -> noise, factor */                      \
  OP(disk_pattern, 2, 7, PURE, NONE)                                                                                   \
  OP(blackbody_light, 1, 3, PURE, table_start, table_count) /* temperature in K, that of the first entry, of the last */ \
  OP(emission, 0, 3, EMITS, NONE)    /* weight, color, strength */                                                     \
  OP(transparent, 0, 2, SEE_THROUGH, NONE) /* weight, color */                                                         \
  OP(diffuse, 0, 4, SCATTERS, NONE)  /* weight, color, roughness, normal */                                            \
  /* weight, color, roughness, normal, anisotropy, rotation, tangent */                                                \
  OP(glossy, 0, 7, SCATTERS, NAMES(GLOSSY_DISTRIBUTIONS))                                                                     \
  /* weight, base color or ior, edge tint or extinction, roughness, normal, anisotropy, rotation, tangent */            \
  OP(metallic, 0, 8, SCATTERS, NAMES(FACET_DISTRIBUTIONS), NAMES(CONDUCTORS))                                                \
  OP(glass, 0, 5, SCATTERS, NAMES(FACET_DISTRIBUTIONS)) /* weight, color, roughness, ior, normal */                          \
  OP(refraction, 0, 5, SCATTERS, NAMES(REFRACTION_DISTRIBUTIONS)) /* weight, color, roughness, ior, normal */                                     \
  OP(translucent, 0, 3, SCATTERS, NONE) /* weight, color, normal */                                                    \
  OP(sheen, 0, 4, SCATTERS, NAMES(SHEEN_MODELS)) /* weight, color, roughness, normal */                                \
  /* weight, color, radius, scale, ior, roughness of the way in squared, anisotropy, normal */                          \
  OP(subsurface, 0, 8, SCATTERS, NAMES(SUBSURFACE_METHODS))                                                            \
  OP(holdout, 0, 1, PER_POINT, NONE) /* weight */                                                                      \
  OP(aov, 0, 1, RECORDS, aov_index)  /* color or number */                                                             \
  /* weight, base color, metallic, roughness, diffuse roughness, ior, specular level, specular tint, transmission,    \
   * alpha, normal, emission color, emission strength, anisotropy, rotation, tangent */                                \
  OP(principled, 0, 16, PRINCIPLED, NAMES(DISTRIBUTIONS))                                                              \
  /* Of the Principled BSDF that comes next. */                                                                        \
  OP(sheen_layer, 0, 3, LAYER, NONE) /* weight, roughness, tint */                                                     \
  OP(coat_layer, 0, 5, LAYER, NONE)  /* weight, roughness, ior, tint, normal */                                        \
  OP(subsurface_layer, 0, 5, LAYER, NAMES(SUBSURFACE_METHODS)) /* weight, radius, scale, ior, anisotropy */ \
  /* Of the principled, metallic or glass that comes next: thickness in nm, ior; that below which it fades; reach of the  \
   * table of sensitivity, which has the real parts of RGB in one row and the imaginary parts in the next */            \
  OP(film, 0, 4, LAYER, table_start, table_count)

#define ENUMERATION(name) name,
typedef enum math_operation { MATH_OPERATIONS(ENUMERATION) } math_operation;
#undef ENUMERATION
#define ENUMERATION(name) BLEND_##name,
typedef enum blend_type { BLEND_TYPES(ENUMERATION) } blend_type;
#undef ENUMERATION
#define ENUMERATION(name) COORDINATE_##name,
typedef enum coordinate_kind { COORDINATES(ENUMERATION) } coordinate_kind;
#undef ENUMERATION
#define ENUMERATION(name) PATH_##name,
typedef enum light_path_kind { LIGHT_PATHS(ENUMERATION) } light_path_kind;
#undef ENUMERATION
#define ENUMERATION(name) MAPPING_##name,
typedef enum mapping_type { MAPPING_TYPES(ENUMERATION) } mapping_type;
#undef ENUMERATION
#define ENUMERATION(name) VECTOR_TYPE_##name,
typedef enum vector_type { VECTOR_TYPES(ENUMERATION) } vector_type;
#undef ENUMERATION
#define ENUMERATION(name) PROJECTION_##name,
typedef enum projection { PROJECTIONS(ENUMERATION) } projection;
#undef ENUMERATION
#define ENUMERATION(name) SPACE_##name,
typedef enum normal_space { NORMAL_SPACES(ENUMERATION) } normal_space;
#undef ENUMERATION

#define ENUMERATION(name) VECTOR_##name,
typedef enum vector_operation { VECTOR_OPERATIONS(ENUMERATION) } vector_operation;
#undef ENUMERATION
#define ENUMERATION(name) MAP_##name,
typedef enum map_interpolation { MAP_INTERPOLATIONS(ENUMERATION) } map_interpolation;
#undef ENUMERATION
#define ENUMERATION(name) MODEL_##name,
typedef enum color_model { COLOR_MODELS(ENUMERATION) } color_model;
#undef ENUMERATION
#define ENUMERATION(name) GRADIENT_##name,
typedef enum gradient_type { GRADIENT_TYPES(ENUMERATION) } gradient_type;
#undef ENUMERATION
#define ENUMERATION(name) WAVE_##name,
typedef enum wave_type { WAVE_TYPES(ENUMERATION) } wave_type;
#undef ENUMERATION
#define ENUMERATION(name) WAVE_##name,
typedef enum wave_direction { WAVE_DIRECTIONS(ENUMERATION) } wave_direction;
#undef ENUMERATION
#define ENUMERATION(name) WAVE_##name,
typedef enum wave_profile { WAVE_PROFILES(ENUMERATION) } wave_profile;
#undef ENUMERATION
#define ENUMERATION(name) CHART_##name,
typedef enum drawn_chart { CHARTS(ENUMERATION) } drawn_chart;
#undef ENUMERATION

#define DECLARATION(name, ...) operation op_##name;
PROGRAM_OPS(DECLARATION)
#undef DECLARATION

/* Begins the definition of an operation. */
#define MAYBE_UNUSED __attribute__((unused))
#define OPERATION(name)                                                                                                \
  void op_##name(const program_context *context MAYBE_UNUSED, const vec3 *const *in MAYBE_UNUSED,                      \
                 const int32_t *immediates MAYBE_UNUSED, vec3 *out MAYBE_UNUSED)
#endif
