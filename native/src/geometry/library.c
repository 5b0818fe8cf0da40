/* dlopen on POSIX, LoadLibrary on Windows. */
#include "geometry/library.h"

#include <stdio.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>

const char *const LIBRARY_EMBREE_NAMES[] = {"embree4.dll", NULL};

library *library_find_loaded(const char *name)
{
  HMODULE module = NULL;
  return GetModuleHandleExA(0, name, &module) ? (library *)module : NULL;
}

/* What the library itself needs is looked for in its own folder, which a name without a folder does not have. */
library *library_open(const char *path, char *reason, size_t size)
{
  wchar_t wide[1024];
  const int is_path = strpbrk(path, "\\/") != NULL;
  HMODULE module = NULL;
  if (MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, sizeof wide / sizeof *wide))
    module = LoadLibraryExW(wide, NULL, is_path ? LOAD_WITH_ALTERED_SEARCH_PATH : 0);
  if (!module) snprintf(reason, size, "error %lu", GetLastError());
  return (library *)module;
}

library_function library_symbol(library *lib, const char *name)
{
  return (library_function)GetProcAddress((HMODULE)lib, name);
}

void library_close(library *lib) { FreeLibrary((HMODULE)lib); }

#else
#include <dlfcn.h>

#if defined(__APPLE__)
const char *const LIBRARY_EMBREE_NAMES[] = {"libembree4.4.dylib", "libembree4.dylib", NULL};
#else
const char *const LIBRARY_EMBREE_NAMES[] = {"libembree4.so.4", "libembree4.so", NULL};
#endif

library *library_find_loaded(const char *name) { return dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD); }

library *library_open(const char *path, char *reason, size_t size)
{
  void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (!handle) {
    const char *message = dlerror();
    snprintf(reason, size, "%s", message ? message : "unknown reason");
  }
  return handle;
}

/* POSIX promises that dlsym's object pointer is the function's address; ISO C has no cast for it. */
library_function library_symbol(library *lib, const char *name)
{
  void *address = dlsym(lib, name);
  library_function function;
  memcpy(&function, &address, sizeof function);
  return function;
}

void library_close(library *lib) { dlclose(lib); }
#endif
