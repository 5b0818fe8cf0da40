/* The part of Embree 4 that Bentlight uses, bound at run time to the copy that Blender ships.
 *
 * Names and layouts follow Embree's own public interface (rtcore, version 4). A scene traces rays with
 * embree()->intersect1; the table exists from the first successful load to the end of the process.
 */
#ifndef BENT_GEOMETRY_EMBREE_H
#define BENT_GEOMETRY_EMBREE_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "bentlight/embree.h"

typedef struct embree_device *embree_device;
typedef struct embree_scene *embree_scene;
typedef struct embree_geometry *embree_geometry;

#define EMBREE_INVALID UINT32_MAX

enum { EMBREE_VERSION_MAJOR = 1, EMBREE_VERSION_MINOR = 2, EMBREE_VERSION_PATCH = 3, EMBREE_RAY_MASK_SUPPORTED = 64,
       EMBREE_BACKFACE_CULLING = 65 };
enum { EMBREE_TRIANGLE = 0, EMBREE_INSTANCE = 121 };
enum { EMBREE_BUFFER_INDEX = 0, EMBREE_BUFFER_VERTEX = 1 };
enum { EMBREE_UINT3 = 0x5003, EMBREE_FLOAT3 = 0x9003, EMBREE_FLOAT3X4_ROW_MAJOR = 0x9134 };
enum { EMBREE_SCENE_DYNAMIC = 1, EMBREE_SCENE_ROBUST = 4 };
enum { EMBREE_QUALITY_MEDIUM = 1, EMBREE_QUALITY_REFIT = 3 };
enum { EMBREE_ERROR_NONE = 0, EMBREE_ERROR_OUT_OF_MEMORY = 4, EMBREE_ERROR_CANCELLED = 6 };

/* RTCRayHit. 96 bytes whether or not Embree was built with instance arrays, which add a word after `instance`. */
typedef struct embree_ray {
  _Alignas(16) float origin[3];
  float near;
  float direction[3];
  float time, far;
  uint32_t mask, id, flags;
  float normal[3];
  float u, v;
  uint32_t triangle, geometry, instance;
  uint32_t reserved[4];
} embree_ray;

typedef struct embree_bounds {
  _Alignas(16) float lower[4];
  float upper[4];
} embree_bounds;

typedef struct embree_table {
  embree_device device;
  embree_device (*new_device)(const char *config);
  void (*release_device)(embree_device);
  ssize_t (*get_device_property)(embree_device, int property);
  int (*get_device_error)(embree_device);
  embree_scene (*new_scene)(embree_device);
  void (*release_scene)(embree_scene);
  void (*set_scene_flags)(embree_scene, int flags);
  void (*set_scene_progress)(embree_scene, bool (*monitor)(void *user, double done), void *user);
  void (*commit_scene)(embree_scene);
  void (*get_scene_bounds)(embree_scene, embree_bounds *);
  void (*attach_geometry_by_id)(embree_scene, embree_geometry, unsigned id);
  embree_geometry (*new_geometry)(embree_device, int type);
  void (*release_geometry)(embree_geometry);
  void (*commit_geometry)(embree_geometry);
  void (*set_geometry_mask)(embree_geometry, unsigned mask);
  void (*set_geometry_build_quality)(embree_geometry, int quality);
  void (*set_shared_geometry_buffer)(embree_geometry, int type, unsigned slot, int format, const void *data,
                                     size_t offset, size_t stride, size_t count);
  void (*update_geometry_buffer)(embree_geometry, int type, unsigned slot);
  void (*set_geometry_instanced_scene)(embree_geometry, embree_scene);
  void (*set_geometry_transform)(embree_geometry, unsigned step, int format, const void *matrix);
  void (*intersect1)(embree_scene, embree_ray *, void *arguments);
} embree_table;

/* The bound table, or NULL before bent_embree_load has succeeded. */
const embree_table *embree(void);
/* Embree's pending error of this thread as a status; `what` names the step that may have failed. */
bent_status embree_check(const char *what, bent_error *error);
#endif
