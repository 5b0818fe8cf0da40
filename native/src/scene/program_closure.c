/* Operations that add lobes and emission to the closure set. The first operand is always the weight of the branch. */
#include "scene/fresnel.h"
#include "scene/program.h"

/* The film that waits, for one closure; NULL: none. */
static const thin_film *take_film(program_layers *layers)
{
  const thin_film *film = layers->has_film ? &layers->film : NULL;
  layers->has_film = 0;
  return film;
}

OPERATION(emission)
{
  /* Negative light is let through, as in Cycles. */
  const vec3 radiance = v3_scale(v3_mul(*in[0], *in[1]), in[2]->x);
  if (v3_is_finite(radiance)) context->set->emission = v3_add(context->set->emission, radiance);
}

OPERATION(transparent)
{
  if (!context->emission_only) closure_add_transparent(context->set, v3_mul(*in[0], v3_positive(*in[1])));
}

OPERATION(diffuse)
{
  if (!context->emission_only) closure_add_diffuse(context->set, context->point, *in[0], *in[1], in[2]->x, *in[3]);
}

OPERATION(glossy)
{
  const stretch stretch = {.anisotropy = in[4]->x, .rotation = in[5]->x, .tangent = *in[6]};
  if (!context->emission_only)
    closure_add_glossy(context->set, context->point, *in[0], *in[1], in[2]->x, *in[3], &stretch,
                       (facets)immediates[0]);
}

OPERATION(metallic)
{
  const stretch stretch = {.anisotropy = in[5]->x, .rotation = in[6]->x, .tangent = *in[7]};
  if (!context->emission_only)
    closure_add_metallic(context->set, context->point, *in[0], *in[1], *in[2], in[3]->x, *in[4], &stretch,
                         take_film(context->layers), (facets)immediates[0], immediates[1]);
}

OPERATION(glass)
{
  if (!context->emission_only)
    closure_add_glass(context->set, context->point, *in[0], *in[1], in[2]->x, in[3]->x, *in[4],
                      take_film(context->layers), (facets)immediates[0]);
}

OPERATION(refraction)
{
  if (!context->emission_only)
    closure_add_refraction(context->set, context->point, *in[0], *in[1], in[2]->x, in[3]->x, *in[4],
                           immediates[0] ? FACETS_BECKMANN : FACETS_GGX);
}

OPERATION(translucent)
{
  if (!context->emission_only) closure_add_translucent(context->set, context->point, *in[0], *in[1], *in[2]);
}

OPERATION(sheen)
{
  if (context->emission_only) return;
  if (immediates[0]) closure_add_sheen(context->set, context->point, *in[0], *in[1], in[2]->x, *in[3]);
  else closure_add_velvet(context->set, context->point, *in[0], *in[1], in[2]->x, *in[3]);
}

OPERATION(holdout)
{
  context->set->holdout = v3_saturate(v3_add(context->set->holdout, *in[0]));
}

OPERATION(principled)
{
  program_layers *layers = context->layers;
  const principled p = {.base_color = *in[1], .metallic = in[2]->x, .roughness = in[3]->x,
                        .diffuse_roughness = in[4]->x, .ior = in[5]->x, .specular_level = in[6]->x,
                        .specular_tint = *in[7], .transmission = in[8]->x, .alpha = in[9]->x, .normal = *in[10],
                        .emission_color = *in[11], .emission_strength = in[12]->x,
                        .stretch = {in[13]->x, in[14]->x, *in[15]}, .multiscatter = immediates[0],
                        .sheen = layers->has_sheen ? &layers->sheen : NULL,
                        .coat = layers->has_coat ? &layers->coat : NULL,
                        .subsurface = layers->has_subsurface ? &layers->subsurface : NULL,
                        .film = take_film(layers)};
  layers->has_sheen = layers->has_coat = layers->has_subsurface = 0;
  if (context->emission_only) closure_emit_principled(context->set, context->point, *in[0], &p);
  else closure_add_principled(context->set, context->point, *in[0], &p);
}

OPERATION(subsurface)
{
  const subsurface s = {.weight = 1, .radius = *in[2], .scale = in[3]->x, .ior = in[4]->x, .alpha = in[5]->x,
                        .anisotropy = in[6]->x, .method = (subsurface_method)immediates[0]};
  if (!context->emission_only) closure_add_subsurface(context->set, context->point, *in[0], *in[1], &s, *in[7]);
}

/* Layers wait for the closure that comes next. */

OPERATION(sheen_layer)
{
  context->layers->sheen = (sheen_layer){in[0]->x, in[1]->x, *in[2]};
  context->layers->has_sheen = 1;
}

OPERATION(coat_layer)
{
  context->layers->coat = (coat_layer){in[0]->x, in[1]->x, in[2]->x, *in[3], *in[4]};
  context->layers->has_coat = 1;
}

OPERATION(subsurface_layer)
{
  context->layers->subsurface = (subsurface){.weight = in[0]->x, .radius = *in[1], .scale = in[2]->x, .ior = in[3]->x,
                                             .anisotropy = in[4]->x, .method = (subsurface_method)immediates[0]};
  context->layers->has_subsurface = 1;
}

OPERATION(film)
{
  context->layers->film = (thin_film){.thickness = in[0]->x, .ior = in[1]->x, .thinnest = in[2]->x, .reach = in[3]->x,
                                      .sensitivity = context->table + immediates[0], .count = immediates[1]};
  context->layers->has_film = immediates[1] >= 4 && in[2]->x > 0 && in[3]->x > 0 && isfinite(in[0]->x + in[1]->x);
}
