/* The one place where array arguments are checked: type, shape, contiguity, finiteness. */
#include "python.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *type_name(char format)
{
  switch (format) {
    case 'd': return "float64";
    case 'f': return "float32";
    case 'i': return "int32";
    case 'I': return "uint32";
    case 'B': return "uint8";
    case 'q': case 'l': return "int64";
    case 'Q': case 'L': return "uint64";
    case 'e': return "float16";
    case 'b': return "int8";
    case '?': return "bool";
    default: return "another type";
  }
}

/* Native byte order only; on LP64 'l' and 'L' are 8 bytes wide, never our 'i' or 'I'. */
static char format_code(const Py_buffer *view)
{
  const char *f = view->format ? view->format : "B";
  if (*f == '@' || *f == '=') f++;
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
  else if (*f == '<') f++;
#endif
  if (f[0] == 0 || f[1] != 0) return 0;
  if (view->itemsize == 8 && *f == 'l') return 'q';
  if (view->itemsize == 4 && *f == 'l') return 'i';
  if (view->itemsize == 4 && *f == 'L') return 'I';
  return *f;
}

static void print_shape(char *out, size_t size, int dimensions, const Py_ssize_t *shape)
{
  size_t used = (size_t)snprintf(out, size, "(");
  for (int i = 0; i < dimensions && used < size; i++) {
    const char *separator = i + 1 < dimensions ? ", " : dimensions == 1 ? "," : "";
    used += shape[i] < 0 ? (size_t)snprintf(out + used, size - used, "n%s", separator)
                         : (size_t)snprintf(out + used, size - used, "%zd%s", shape[i], separator);
  }
  if (used < size) snprintf(out + used, size - used, ")");
}

static int all_finite(const Py_buffer *view, char format)
{
  const Py_ssize_t n = view->len / view->itemsize;
  if (format == 'd') {
    const double *v = view->buf;
    for (Py_ssize_t i = 0; i < n; i++)
      if (!isfinite(v[i])) return 0;
  } else if (format == 'f') {
    const float *v = view->buf;
    for (Py_ssize_t i = 0; i < n; i++)
      if (!isfinite(v[i])) return 0;
  }
  return 1;
}

int buffer_get(buffer *out, PyObject *object, const char *name, char format, int dimensions, Py_ssize_t *shape,
               int flags)
{
  memset(out, 0, sizeof *out);
  if ((flags & BUFFER_OPTIONAL) && (!object || object == Py_None)) return 0;
  const int wanted = PyBUF_FORMAT | PyBUF_ND | PyBUF_STRIDES | (flags & BUFFER_WRITE ? PyBUF_WRITABLE : 0);
  if (!object || PyObject_GetBuffer(object, &out->view, wanted) < 0) {
    PyErr_Clear();
    PyErr_Format(PyExc_TypeError, "%s: expected a %s%s array", name, flags & BUFFER_WRITE ? "writable " : "",
                 type_name(format));
    return -1;
  }
  out->held = 1;
  int fits = format_code(&out->view) == format && out->view.ndim == dimensions &&
             PyBuffer_IsContiguous(&out->view, 'C');
  for (int i = 0; fits && i < dimensions; i++) fits = shape[i] < 0 || shape[i] == out->view.shape[i];
  if (!fits) {
    char expected[96], got[96];
    print_shape(expected, sizeof expected, dimensions, shape);
    print_shape(got, sizeof got, out->view.ndim, out->view.shape);
    PyErr_Format(PyExc_ValueError, "%s: expected %s C-contiguous array of shape %s, got %s %s%s", name,
                 type_name(format), expected, type_name(format_code(&out->view)), got,
                 PyBuffer_IsContiguous(&out->view, 'C') ? "" : ", not C-contiguous");
    buffer_release(out);
    return -1;
  }
  for (int i = 0; i < dimensions; i++) shape[i] = out->view.shape[i];
  if ((flags & BUFFER_FINITE) && !all_finite(&out->view, format)) {
    PyErr_Format(PyExc_ValueError, "%s: contains NaN or infinity", name);
    buffer_release(out);
    return -1;
  }
  return 0;
}

void buffer_release(buffer *b)
{
  if (b->held) PyBuffer_Release(&b->view);
  b->held = 0;
}

void buffer_release_all(buffer *buffers, size_t count)
{
  for (size_t i = 0; i < count; i++) buffer_release(&buffers[i]);
}
