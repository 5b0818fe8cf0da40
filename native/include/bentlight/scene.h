/* A scene: edit it from one thread, commit it, then read it from many.
 *
 * Meshes, images and materials are copied in and named by the integer that add_* returns; they count from 0. World
 * coordinates are the Blender scene's. Nothing an edit does is visible before bent_scene_commit.
 */
#ifndef BENTLIGHT_SCENE_H
#define BENTLIGHT_SCENE_H
#include <stddef.h>
#include "bentlight/spacetime.h"

typedef struct bent_scene bent_scene;

bent_status bent_scene_new(bent_scene **out, bent_error *error);
void bent_scene_free(bent_scene *scene);
/* Makes all edits visible. Builds or refits what changed. */
bent_status bent_scene_commit(bent_scene *scene, bent_progress *progress, bent_error *error);

/* A triangle mesh. Pointers may be NULL where said so. All arrays are copied. */
typedef struct bent_mesh {
  size_t vertex_count, triangle_count;
  const float (*vertices)[3];             /* finite */
  const uint32_t (*triangles)[3];         /* vertex indices */
  const float (*corner_normals)[3][3];    /* per triangle corner, flat-space unit normals; NULL: flat shading */
  const float (*corner_uvs)[3][2];        /* per triangle corner; NULL: zero */
  const uint32_t *material_slots;         /* per triangle, index into the instance's materials; NULL: 0 */
  const float (*generated)[3];            /* per vertex, Blender's generated coordinates in [0, 1]; NULL: zero */
} bent_mesh;

/* Whom the light of an emitter (an emissive instance, a lamp or a sun) reaches: as Cycles limits and links lights.
 * Every instance is in one of 64 sets of receivers and in one of 64 sets of blockers. */
typedef struct bent_influence {
  uint64_t receivers;   /* bit i: it lights what is in receiver set i */
  uint64_t blockers;    /* bit i: what is in blocker set i holds its light up; 0: it lights all without shadows */
  uint32_t max_bounces; /* it lights what the camera sees after so many scatterings at most */
} bent_influence;
#define BENT_INFLUENCE_ALL ((bent_influence){UINT64_MAX, UINT64_MAX, UINT32_MAX})
enum { BENT_LINK_SETS = 64 };

typedef struct bent_instance {
  int mesh;
  double world_from_mesh[4][4]; /* any invertible affine matrix, mirrored and non-uniform included */
  const int *materials;         /* one material per slot; NULL with count 0: the default grey */
  size_t material_count;
  uint32_t visibility;          /* bent_visibility bits: the kinds of ray that see it, and the flags below those */
  float object_index;           /* for object info and index passes */
  float color[4];               /* for object info: RGB and alpha */
  float random;                 /* for object info: in [0, 1] */
  uint32_t one_sided;           /* emits and is seen only on the side of the geometric normal (area lights) */
  bent_influence influence;     /* of the light that it emits */
  uint32_t receiver_set, blocker_set; /* that it is in; below BENT_LINK_SETS */
} bent_instance;

typedef enum bent_visibility {
  BENT_VISIBLE_CAMERA = 1,
  BENT_VISIBLE_DIFFUSE = 2,
  BENT_VISIBLE_GLOSSY = 4,
  BENT_VISIBLE_TRANSMISSION = 8,
  BENT_VISIBLE_ALL = 15,
  BENT_HOLDOUT = 16, /* no kind of ray: the camera sees a hole in the picture (alpha 0) where the instance is */
  BENT_SHADOWLESS = 32, /* no kind of ray: the instance casts no shadow */
  BENT_SHADOW = 64, /* the kind of ray that asks what is between a surface and a light; not for instances */
  BENT_IMMATERIAL = 128 /* no kind of ray: all that the instance does to rays is to send light along them, as lamps do
                         * in Cycles; they go straight on, each time as through a transparent surface; it casts no
                         * shadow */
} bent_visibility;

bent_status bent_scene_add_mesh(bent_scene *scene, const bent_mesh *mesh, int *index, bent_error *error);
/* Gives the corners of a mesh's triangles values that materials ask for by `id` (0 or more): (triangle_count, 3,
 * components) finite floats, 1 to 4 components, copied. */
bent_status bent_scene_set_mesh_attribute(bent_scene *scene, int mesh, int id, int components, size_t triangle_count,
                                          const float *values, bent_error *error);
/* The same of an instance as a whole; of a mesh that has the same attribute, its own counts. */
bent_status bent_scene_set_instance_attribute(bent_scene *scene, int instance, int id, const float value[4],
                                              bent_error *error);
/* Replaces the vertices (and corner normals and generated coordinates, if not NULL) of a mesh; the counts and everything
 * else stay. The tree is refitted while the vertices stay near where it was built, else rebuilt. */
bent_status bent_scene_update_mesh(bent_scene *scene, int mesh, const bent_mesh *data, bent_error *error);
bent_status bent_scene_add_instance(bent_scene *scene, const bent_instance *instance, int *index, bent_error *error);
bent_status bent_scene_update_instance(bent_scene *scene, int instance, const double world_from_mesh[4][4],
                                       bent_error *error);
bent_status bent_scene_clear_instances(bent_scene *scene, bent_error *error);

/* What is odd about a mesh. Such triangles do no harm: rays never hit the first two kinds, and of duplicates either
 * one. */
typedef struct bent_mesh_report {
  size_t degenerate; /* without area in float32: repeated or collinear vertices, or too tiny */
  size_t too_large;  /* with a coordinate beyond 1.8e18, which Embree ignores */
  size_t duplicate;  /* with the same three corners as another one, in any order */
} bent_mesh_report;
bent_status bent_scene_report_mesh(const bent_scene *scene, int mesh, bent_mesh_report *out, bent_error *error);

/* One spacetime object in the scene. A single object that is not a wormhole pair may have sphere_radius INFINITY: it
 * bends space out to infinity, exactly. Otherwise each owns a sphere (world units, around its origin, chart radius) and
 * space outside all spheres is flat. Spheres must not overlap. */
typedef struct bent_spacetime_object {
  bent_spacetime spacetime;
  double world_from_spacetime[4][4]; /* rotation, uniform positive scale, translation */
  double sphere_radius; /* 0: the default, infinite for a lone object, else half-way to the nearest neighbor */
  int exit; /* wormhole: index of the object where rays through the throat come out, or -1: an empty sky of its own */
} bent_spacetime_object;

bent_status bent_scene_set_spacetimes(bent_scene *scene, size_t count, const bent_spacetime_object *objects,
                                      bent_error *error);
#endif
