/* The one place where error messages are formatted. */
#include "bentlight/error.h"

#include <stdarg.h>
#include <stdio.h>

bent_status bent_fail(bent_error *error, bent_status status, const char *format, ...)
{
  if (error) {
    va_list arguments;
    va_start(arguments, format);
    error->status = status;
    vsnprintf(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
  }
  return status;
}
