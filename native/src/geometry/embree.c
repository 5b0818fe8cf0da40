/* Finds Embree 4, checks that it is one this code understands, and binds its functions. */
#include "geometry/embree.h"

#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "geometry/library.h"

typedef struct binding {
  embree_table table;
  library *lib;
  char version[32];
  char origin[1024];
} binding;

/* Published once, by compare-and-swap; a thread that comes second throws its own binding away. */
static _Atomic(binding *) bound;

static const struct {
  const char *name;
  size_t offset;
} SYMBOLS[] = {
    {"rtcNewDevice", offsetof(embree_table, new_device)},
    {"rtcReleaseDevice", offsetof(embree_table, release_device)},
    {"rtcGetDeviceProperty", offsetof(embree_table, get_device_property)},
    {"rtcGetDeviceError", offsetof(embree_table, get_device_error)},
    {"rtcNewScene", offsetof(embree_table, new_scene)},
    {"rtcReleaseScene", offsetof(embree_table, release_scene)},
    {"rtcSetSceneFlags", offsetof(embree_table, set_scene_flags)},
    {"rtcSetSceneProgressMonitorFunction", offsetof(embree_table, set_scene_progress)},
    {"rtcCommitScene", offsetof(embree_table, commit_scene)},
    {"rtcGetSceneBounds", offsetof(embree_table, get_scene_bounds)},
    {"rtcAttachGeometryByID", offsetof(embree_table, attach_geometry_by_id)},
    {"rtcNewGeometry", offsetof(embree_table, new_geometry)},
    {"rtcReleaseGeometry", offsetof(embree_table, release_geometry)},
    {"rtcCommitGeometry", offsetof(embree_table, commit_geometry)},
    {"rtcSetGeometryMask", offsetof(embree_table, set_geometry_mask)},
    {"rtcSetGeometryBuildQuality", offsetof(embree_table, set_geometry_build_quality)},
    {"rtcSetSharedGeometryBuffer", offsetof(embree_table, set_shared_geometry_buffer)},
    {"rtcUpdateGeometryBuffer", offsetof(embree_table, update_geometry_buffer)},
    {"rtcSetGeometryInstancedScene", offsetof(embree_table, set_geometry_instanced_scene)},
    {"rtcSetGeometryTransform", offsetof(embree_table, set_geometry_transform)},
    {"rtcIntersect1", offsetof(embree_table, intersect1)},
};

/* The message grows by one clause per library that was tried. */
__attribute__((format(printf, 2, 3))) static void note(char tried[400], const char *format, ...)
{
  const size_t used = strlen(tried);
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(tried + used, 400 - used, format, arguments);
  va_end(arguments);
}

/* Looks every function up. Returns the missing one's name, or NULL. */
static const char *bind_symbols(binding *b)
{
  for (size_t i = 0; i < sizeof SYMBOLS / sizeof *SYMBOLS; i++) {
    const library_function function = library_symbol(b->lib, SYMBOLS[i].name);
    if (!function) return SYMBOLS[i].name;
    memcpy((char *)&b->table + SYMBOLS[i].offset, &function, sizeof function);
  }
  return NULL;
}

/* Takes over `lib`: a complete binding, or NULL with the reason appended to `tried` and the library closed. */
static binding *bind_library(library *lib, const char *origin, char tried[400])
{
  binding *b = calloc(1, sizeof *b);
  if (!b) {
    library_close(lib);
    note(tried, "; out of memory");
    return NULL;
  }
  b->lib = lib;
  snprintf(b->origin, sizeof b->origin, "%s", origin);
  embree_table *t = &b->table;
  const char *missing = bind_symbols(b);
  /* An old Embree lacks none of the functions that tell its version, so ask for that before complaining of others. */
  if (t->new_device && t->get_device_property && t->release_device) t->device = t->new_device(NULL);
  if (t->device) {
    const int major = (int)t->get_device_property(t->device, EMBREE_VERSION_MAJOR);
    snprintf(b->version, sizeof b->version, "%d.%d.%d", major,
             (int)t->get_device_property(t->device, EMBREE_VERSION_MINOR),
             (int)t->get_device_property(t->device, EMBREE_VERSION_PATCH));
    if (major != 4) note(tried, "; %s is Embree %s, but version 4 is needed", origin, b->version);
    else if (missing) note(tried, "; %s (Embree %s) lacks %s", origin, b->version, missing);
    else if (!t->get_device_property(t->device, EMBREE_RAY_MASK_SUPPORTED))
      note(tried, "; %s (Embree %s) was built without ray masks", origin, b->version);
    else if (t->get_device_property(t->device, EMBREE_BACKFACE_CULLING))
      note(tried, "; %s (Embree %s) was built with backface culling", origin, b->version);
    else return b;
    t->release_device(t->device);
  } else {
    note(tried, missing ? "; %s lacks %s" : "; %s could not start on this processor", origin, missing);
  }
  library_close(lib);
  free(b);
  return NULL;
}

static binding *find(size_t count, const char *const *paths, char tried[400])
{
  char origin[256];
  for (const char *const *name = LIBRARY_EMBREE_NAMES; *name; name++) {
    library *lib = library_find_loaded(*name);
    snprintf(origin, sizeof origin, "already loaded %s", *name);
    binding *b = lib ? bind_library(lib, origin, tried) : NULL;
    if (b) return b;
  }
  if (count == 0) {
    paths = LIBRARY_EMBREE_NAMES;
    while (paths[count]) count++;
  }
  for (size_t i = 0; i < count; i++) {
    char reason[160] = "";
    library *lib = library_open(paths[i], reason, sizeof reason);
    if (!lib) note(tried, "; %s: %s", paths[i], reason);
    binding *b = lib ? bind_library(lib, paths[i], tried) : NULL;
    if (b) return b;
  }
  return NULL;
}

bent_status bent_embree_load(size_t count, const char *const *paths, bent_error *error)
{
  if (atomic_load(&bound)) return BENT_OK;
  char tried[400] = "";
  binding *b = find(count, paths, tried);
  if (!b) return bent_fail(error, BENT_ERROR_UNAVAILABLE, "Embree 4 is needed to trace meshes and was not found%s", tried);
  binding *expected = NULL;
  if (!atomic_compare_exchange_strong(&bound, &expected, b)) {
    b->table.release_device(b->table.device);
    library_close(b->lib);
    free(b);
  }
  return BENT_OK;
}

const char *bent_embree_version(void)
{
  const binding *b = atomic_load(&bound);
  return b ? b->version : NULL;
}

const char *bent_embree_origin(void)
{
  const binding *b = atomic_load(&bound);
  return b ? b->origin : NULL;
}

const embree_table *embree(void)
{
  const binding *b = atomic_load_explicit(&bound, memory_order_acquire);
  return b ? &b->table : NULL;
}

bent_status embree_check(const char *what, bent_error *error)
{
  const embree_table *e = embree();
  const int code = e->get_device_error(e->device);
  if (code == EMBREE_ERROR_NONE) return BENT_OK;
  if (code == EMBREE_ERROR_OUT_OF_MEMORY) return bent_fail(error, BENT_ERROR_MEMORY, "%s: out of memory", what);
  if (code == EMBREE_ERROR_CANCELLED) return bent_fail(error, BENT_CANCELLED, "%s: cancelled", what);
  return bent_fail(error, BENT_ERROR_STATE, "%s: Embree error %d", what, code);
}
