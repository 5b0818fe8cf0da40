/* Module functions of the accretion disk: numbers in, a number out (scene/disk.h). */
#include "python.h"
#include "scene/disk.h"

/* Checks what all functions take: a radius outside the horizon (0: none is asked for) and a spin. Returns 0, or -1 with a
 * ValueError. */
static int check(double radius, double spin)
{
  if (!(fabs(spin) < 1)) {
    PyErr_SetString(PyExc_ValueError, "spin: must be smaller than 1 in size");
    return -1;
  }
  if (radius != 0 && !(isfinite(radius) && radius > 1 + sqrt((1 - spin) * (1 + spin)))) {
    PyErr_SetString(PyExc_ValueError, "radius: must be finite and outside the horizon");
    return -1;
  }
  return 0;
}

static PyObject *isco(PyObject *module, PyObject *args)
{
  (void)module;
  double spin;
  if (!PyArg_ParseTuple(args, "d:disk_isco", &spin) || check(0, spin) < 0) return NULL;
  return PyFloat_FromDouble(disk_isco(fabs(spin)));
}

/* Arguments (radius, spin). */
static int get_place(PyObject *args, double *radius, double *spin)
{
  if (!PyArg_ParseTuple(args, "dd", radius, spin)) return -1;
  if (*radius == 0) *radius = -1;
  return check(*radius, *spin);
}

static PyObject *flux(PyObject *module, PyObject *args)
{
  (void)module;
  double radius, spin;
  return get_place(args, &radius, &spin) < 0 ? NULL : PyFloat_FromDouble(disk_flux(radius, fabs(spin)));
}

static PyObject *orbit_frequency(PyObject *module, PyObject *args)
{
  (void)module;
  double radius, spin;
  return get_place(args, &radius, &spin) < 0 ? NULL : PyFloat_FromDouble(disk_orbit_frequency(radius, fabs(spin)));
}

static PyObject *drawn_radius(PyObject *module, PyObject *args)
{
  (void)module;
  double radius, spin;
  int isotropic;
  if (!PyArg_ParseTuple(args, "ddp", &radius, &spin, &isotropic) || check(radius == 0 ? -1 : radius, spin) < 0) return NULL;
  return PyFloat_FromDouble(isotropic ? disk_drawn_isotropic(radius) : disk_drawn_oblate(radius, spin));
}

PyMethodDef disk_functions[] = {
    {"disk_isco", isco, METH_VARARGS,
     "disk_isco(spin) -> float\n\nRadius, in masses, of the innermost stable circular orbit that runs with the hole's "
     "rotation (Bardeen, Press & Teukolsky 1972). spin: a/M, below 1 in size."},
    {"disk_flux", flux, METH_VARARGS,
     "disk_flux(radius, spin) -> float\n\nWhat each side of a thin disk radiates per area and time in the frame of its "
     "matter, times 4 pi M^2 over the rate of accretion (Page & Thorne 1974, eq. 15n); 0 within the ISCO. radius: "
     "Boyer-Lindquist over mass, outside the horizon."},
    {"disk_orbit_frequency", orbit_frequency, METH_VARARGS,
     "disk_orbit_frequency(radius, spin) -> float\n\nAngular frequency, as seen from afar, of a circular orbit, times the "
     "hole's mass."},
    {"disk_drawn_radius", drawn_radius, METH_VARARGS,
     "disk_drawn_radius(radius, spin, isotropic) -> float\n\nHow far from the hole's center a place of the equatorial plane "
     "is drawn, in masses, by the isotropic chart (spin 0) or else the oblate one."},
    {0}};
