/* Meshes, instances and spacetime objects of a scene, and the Embree scenes built from them. */
#ifndef BENT_GEOMETRY_GEOMETRY_H
#define BENT_GEOMETRY_GEOMETRY_H
#include "base/vec3.h"
#include "bentlight/intersect.h"
#include "bentlight/scene.h"
#include "bentlight/sphere.h"
#include "bentlight/table.h"
#include "geometry/embree.h"
#include "scene/attribute.h"

typedef struct mesh {
  size_t vertex_count, triangle_count;
  float (*vertices)[3]; /* one more than vertex_count: Embree reads 16 bytes at the last one */
  uint32_t (*triangles)[3];
  float (*corner_normals)[3][3]; /* from here on NULL if not given */
  float (*corner_uvs)[3][2];
  uint32_t *material_slots;
  float (*generated)[3];
  attribute_list attributes;

  embree_scene scene;       /* NULL until an instance needs it */
  embree_geometry triangle; /* the one geometry in `scene` */
  float (*built)[3];        /* vertices of the last full build, kept once the mesh has been updated */
  int moved;                /* vertices changed since the last commit */
  int refittable;           /* `scene` is dynamic: a refit will do for small moves */
} mesh;

typedef struct instance {
  int mesh;
  mat4 world_from_mesh, mesh_from_world;
  int *materials;
  size_t material_count;
  uint32_t visibility;
  float object_index, color[4], random;
  attribute_list attributes;
  uint32_t one_sided;
  bent_influence influence;
  uint32_t receiver_set, blocker_set;
  /* Where Embree, in float32, sees a point x of this instance is off by at most float_error_offset +
   * float_error_scale * max|x_i - origin_i| world units: rounding of the point, of the matrix and of its inverse. */
  double float_error_offset, float_error_scale;
} instance;

/* Whether anything that rays can meet reaches into the sphere of a lens. */
typedef enum clearness { CLEARNESS_UNKNOWN, OCCUPIED, CLEAR } clearness;

/* A spacetime object with what intersection needs of it, in world units. */
typedef struct lens {
  bent_spacetime spacetime;
  mat4 world_from_spacetime, spacetime_from_world;
  vec3 center;   /* world */
  double scale;  /* world units per spacetime unit */
  double radius; /* of its sphere, world units; INFINITY for a single object */
  int flat;      /* bends nothing: Minkowski or no mass */
  int exit;      /* index of the mouth where rays through the throat come out; -1: none */
  bent_table *table;  /* of deflection, for the way to infinity; NULL where there is none (jump.h) */
  double table_error; /* its measured maximum, radians */
  clearness clearness; /* of a finite sphere that can be crossed by table; as of the last commit */
  bent_sphere *sphere; /* how a clear one is crossed; NULL until it is one (cross.h). Equal lenses share it */
} lens;

typedef struct geometry {
  mesh *meshes;
  size_t mesh_count, mesh_capacity;
  instance *instances;
  size_t instance_count, instance_capacity;
  lens *lenses;
  size_t lens_count;

  embree_scene top; /* instances of the meshes' scenes; instance i has geometry id i; its origin is `origin` */
  vec3 origin;      /* world: that of all coordinates handed to Embree, so that its float32 is good far away too */
  int changed;      /* something must be rebuilt by the next commit */
  vec3 center;      /* bounding sphere of everything that can be hit, world; radius -1 when there is nothing */
  double radius;
} geometry;

bent_status geometry_new(geometry **out, bent_error *error);
void geometry_free(geometry *g);
/* Builds or refits what changed since the last commit. */
bent_status geometry_commit(geometry *g, bent_progress *progress, bent_error *error);

/* The kinds of ray that meet an instance, shadows among them. */
static inline uint32_t instance_mask(const instance *i)
{
  const uint32_t casts_none = i->visibility & (BENT_SHADOWLESS | BENT_IMMATERIAL);
  return (i->visibility & BENT_VISIBLE_ALL) | (casts_none ? 0 : BENT_SHADOW);
}

/* Whether rays can meet anything of the instance. */
static inline int is_seen(const geometry *g, const instance *i)
{
  return g->meshes[i->mesh].triangle_count && instance_mask(i);
}

/* Vertex `corner` of a triangle of an instance, in world coordinates. */
static inline vec3 geometry_vertex(const geometry *g, int instance_index, int triangle, int corner)
{
  const instance *i = &g->instances[instance_index];
  const mesh *m = &g->meshes[i->mesh];
  const float *v = m->vertices[m->triangles[triangle][corner]];
  return mat4_point(&i->world_from_mesh, v3(v[0], v[1], v[2]));
}

/* The material of a triangle of an instance; -1: the default. */
static inline int geometry_material(const geometry *g, const instance *i, int triangle)
{
  const uint32_t *slots = g->meshes[i->mesh].material_slots, slot = slots ? slots[triangle] : 0;
  return slot < i->material_count ? i->materials[slot] : -1;
}

/* Frees lenses and their tables. */
void lenses_free(lens *lenses, size_t count);
/* The lens whose sphere contains the world point, or NULL where space is flat. */
const lens *geometry_lens_at(const geometry *g, vec3 position);
/* The distance of a world point from the nearest center of a lens that bends; INFINITY where there is none. */
double geometry_lens_distance(const geometry *g, vec3 position);
#endif
