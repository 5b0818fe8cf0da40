/* The table of contents of bentlight_native._core. */
#include "python.h"
#include "base/isa.h"

static PyObject *instruction_set(PyObject *module, PyObject *unused)
{
  (void)module, (void)unused;
  return PyUnicode_FromString(bent_isa_name());
}

static PyMethodDef module_functions[] = {
    {"instruction_set", instruction_set, METH_NOARGS,
     "instruction_set() -> str\n\nThe SIMD level in use: 'v2', 'v3', 'v4' (x86-64 levels) or 'neon'."},
    {0}};

static int execute(PyObject *module)
{
  if (errors_add_types(module) < 0 || spacetime_add_type(module) < 0 || progress_add_type(module) < 0 ||
      scene_add_type(module) < 0 || table_add_type(module) < 0 || sphere_add_type(module) < 0)
    return -1;
  PyMethodDef *const topics[] = {module_functions, embree_functions, trace_functions, connect_functions,
                                 table_functions, sphere_functions, render_functions, channel_functions, disk_functions, star_functions};
  for (size_t i = 0; i < sizeof topics / sizeof *topics; i++)
    if (PyModule_AddFunctions(module, topics[i]) < 0) return -1;
  return 0;
}

static PyModuleDef_Slot slots[] = {{Py_mod_exec, execute}, {0, NULL}};
static PyModuleDef definition = {PyModuleDef_HEAD_INIT, .m_name = "bentlight_native._core",
                                 .m_doc = "Bentlight's native core; use bentlight_native.", .m_slots = slots};

PyMODINIT_FUNC PyInit__core(void) { return PyModuleDef_Init(&definition); }
