/* What the files of the Python module share: the stable ABI, argument buffers, errors, and the two handle types.
 *
 * Python sees heap types, never pointers or integers: a wrong object is a TypeError. Arrays come in through the buffer
 * protocol (no NumPy headers) and are allocated by the numpy-facing wrappers in python/bentlight_native.
 */
#ifndef BENT_PYTHON_PYTHON_H
#define BENT_PYTHON_PYTHON_H
#define PY_SSIZE_T_CLEAN
#ifndef Py_LIMITED_API
#define Py_LIMITED_API 0x030B0000
#endif
#include <Python.h>

#include "bentlight.h"

/* buffers.c ------------------------------------------------------------------------------------------------------ */

/* An array argument: acquired by buffer_get, released by buffer_release (safe on a zeroed struct). */
typedef struct buffer {
  Py_buffer view;
  int held;
} buffer;

enum { BUFFER_READ = 0, BUFFER_WRITE = 1, BUFFER_FINITE = 2, BUFFER_OPTIONAL = 4 };

/* Takes `object` as a C-contiguous array of element type `format` ('d', 'f', 'i', 'I', 'B') whose shape matches
 * `shape` (`dimensions` entries; -1 accepts any length and stores it back). With BUFFER_FINITE, NaN and infinity are
 * refused; with BUFFER_OPTIONAL, None gives a NULL pointer. Returns 0, or -1 with a Python error such as "vertices:
 * expected float32 C-contiguous array of shape (n, 3), got float64 (8, 3)". */
int buffer_get(buffer *out, PyObject *object, const char *name, char format, int dimensions, Py_ssize_t *shape,
               int flags);
static inline void *buffer_data(const buffer *b) { return b->held ? b->view.buf : NULL; }
void buffer_release(buffer *b);
void buffer_release_all(buffer *buffers, size_t count);

/* influence.c ---------------------------------------------------------------------------------------------------- */

/* Takes a tuple (receivers, blockers, max_bounces). Returns 0, or -1 with a Python error. */
int influence_get(PyObject *object, bent_influence *out);

/* errors.c ------------------------------------------------------------------------------------------------------- */

/* Raises the Python exception that fits `error` and returns NULL: ARGUMENT and DATA ValueError, MEMORY MemoryError,
 * STATE RuntimeError, UNAVAILABLE OSError, CANCELLED KeyboardInterrupt-free bentlight_native.Cancelled. */
PyObject *raise_error(const bent_error *error);
int errors_add_types(PyObject *module);

/* spacetime.c, scene.c, progress.c ------------------------------------------------------------------------------- */

/* Frees an object of a heap type and its hold on the type; what the object itself holds must be gone. */
static inline void object_free(PyObject *self)
{
  PyTypeObject *type = Py_TYPE(self);
  freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
  release(self);
  Py_DECREF(type);
}

int spacetime_add_type(PyObject *module);
int progress_add_type(PyObject *module);
int scene_add_type(PyObject *module);
int table_add_type(PyObject *module);
int sphere_add_type(PyObject *module);
/* The value inside a Spacetime, or NULL with TypeError. */
const bent_spacetime *spacetime_value(PyObject *object);
/* The cell inside a Progress; None gives NULL with *ok = 1. */
bent_progress *progress_value(PyObject *object, int *ok);
/* The scene inside a Scene, or NULL with TypeError. */
bent_scene *scene_value(PyObject *object);

/* The number of a name in a list, or -1 with a ValueError that says what was asked for: scene_render.c. */
int choose(const char *text, const char *what, const char *const *names, int count);

/* channels.c: arrays by name from a dict {channel name: array (height, width, components)} in the order of the table; and
 * the state of a render that wants those, None gives none. Both return 0, or -1 with a Python error. */
int channels_get(PyObject *dict, Py_ssize_t height, Py_ssize_t width, const bent_render_settings *settings,
                 buffer buffers[BENT_CHANNELS_MAX], float *arrays[BENT_CHANNELS_MAX]);
int state_get(buffer *out, PyObject *object, const bent_render_settings *settings, Py_ssize_t height, Py_ssize_t width,
              float *const channels[BENT_CHANNELS_MAX]);

/* The filter of that name, or -1 with a ValueError: scene_render.c. */
int filter_value(const char *name);

/* Methods of Scene, by topic: scene_geometry.c, scene_shading.c, scene_render.c, scene_stars.c, scene_labels.c, scene_motion.c. */
extern PyMethodDef scene_geometry_methods[], scene_shading_methods[], scene_render_methods[], scene_star_methods[],
    scene_label_methods[], scene_motion_methods[];
/* Functions of the module, by topic. */
extern PyMethodDef trace_functions[], connect_functions[], table_functions[], sphere_functions[], render_functions[], channel_functions[],
    embree_functions[], disk_functions[], star_functions[];
#endif
