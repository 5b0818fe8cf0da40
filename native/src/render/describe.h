/* What the camera ray's surface says to the channels that are not light: depth, position, normals, albedo. */
#ifndef BENT_RENDER_DESCRIBE_H
#define BENT_RENDER_DESCRIBE_H
#include "render/channels.h"
#include "light/surface.h"
#include "render/path.h"
#include "scene/shading.h"

void record_vec3(sample_record *record, channel channel, vec3 value);
/* Adds to a channel. */
void record_add(sample_record *record, channel channel, vec3 value);
/* Mean normal of a surface's lobes, but for transparent ones. */
vec3 describe_normal(const shade_point *point, const closure_set *set);
/* Depth, position, normal and what else passes tell of the first surface that is opaque enough, `length` along the ray; once
 * a path. And, of each, what is weighed by how much the camera sees of it: colors, mist, Cryptomatte. */
void describe_surface(const tracer *tracer, path *path, double length, sample_record *record,
                      const surface *surface, const closure_set *set);
/* Where a surface's material or the sky's writes AOVs. */
aov_sink describe_aovs(const tracer *tracer, const sample_record *record);
/* The sky, where a camera ray of that history has escaped to. */
void describe_sky(const tracer *tracer, const path *path, const bent_hit *hit, const ray_history *history,
                  sample_record *record);
/* Denoising depth: the next leg of the way to the surface that describe_features takes. */
void describe_way(const tracer *tracer, const path *path, double length, sample_record *record);
/* Denoising albedo and normal of the first surface that is not mostly mirror, glass or transparent; once a path. */
void describe_features(const tracer *tracer, path *path, sample_record *record, const shade_point *point,
                       const closure_set *set);
#endif
