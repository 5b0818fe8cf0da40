/* What the camera ray's surface says to the channels that are not light: depth, position, normals, albedo. */
#ifndef BENT_RENDER_DESCRIBE_H
#define BENT_RENDER_DESCRIBE_H
#include "render/channels.h"
#include "render/path.h"
#include "scene/shading.h"

void record_vec3(sample_record *record, channel channel, vec3 value);
/* Adds to a channel. */
void record_add(sample_record *record, channel channel, vec3 value);
/* Depth, position and normal of the first surface that is opaque enough, `length` along the ray; once a path. */
void describe_surface(const tracer *tracer, path *path, double length, sample_record *record,
                      const shade_point *point, const closure_set *set);
/* Denoising albedo and normal of the first surface that is not mostly mirror, glass or transparent; once a path. */
void describe_features(const tracer *tracer, path *path, sample_record *record, const shade_point *point,
                       const closure_set *set);
#endif
