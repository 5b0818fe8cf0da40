/* Operations that add lobes and emission to the closure set. The first operand is always the weight of the branch. */
#include "scene/fresnel.h"
#include "scene/program.h"

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
    closure_add_glossy(context->set, context->point, *in[0], *in[1], in[2]->x, *in[3], &stretch, immediates[0]);
}

OPERATION(metallic)
{
  const stretch stretch = {.anisotropy = in[5]->x, .rotation = in[6]->x, .tangent = *in[7]};
  if (!context->emission_only)
    closure_add_metallic(context->set, context->point, *in[0], *in[1], *in[2], in[3]->x, *in[4], &stretch,
                         immediates[0], immediates[1]);
}

OPERATION(glass)
{
  if (!context->emission_only)
    closure_add_glass(context->set, context->point, *in[0], *in[1], in[2]->x, in[3]->x, *in[4], immediates[0]);
}

OPERATION(refraction)
{
  if (!context->emission_only)
    closure_add_refraction(context->set, context->point, *in[0], *in[1], in[2]->x, in[3]->x, *in[4]);
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
  const principled p = {.base_color = *in[1], .metallic = in[2]->x, .roughness = in[3]->x,
                        .diffuse_roughness = in[4]->x, .ior = in[5]->x, .specular_level = in[6]->x,
                        .specular_tint = *in[7], .transmission = in[8]->x, .alpha = in[9]->x, .normal = *in[10],
                        .emission_color = *in[11], .emission_strength = in[12]->x,
                        .stretch = {in[13]->x, in[14]->x, *in[15]}, .coat_weight = in[16]->x,
                        .coat_roughness = in[17]->x, .coat_ior = in[18]->x, .coat_tint = *in[19],
                        .coat_normal = *in[20], .sheen_weight = in[21]->x, .sheen_roughness = in[22]->x,
                        .sheen_tint = *in[23], .multiscatter = immediates[0]};
  if (context->emission_only) closure_emit_principled(context->set, context->point, *in[0], &p);
  else closure_add_principled(context->set, context->point, *in[0], &p);
}
