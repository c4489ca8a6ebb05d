/* The calls of NetCDF's library that bw_netcdf_reading.f90 makes. Few scenes need it, and loading it with its
   dependencies takes longer than most scenes: so the first call loads it. NETCDF_PATH and NETCDF_NAME are its file, with its directory
   and without, as found by the build. */
#include <dlfcn.h>
#include <stddef.h>
#include <string.h>

void bw_let_library_read(const char *path);                  /* bw_system.c: a crash names this file */
static char path[4096];                                      /* of the last file opened */

/* Store a path without the two letters that `plain_path` puts before it. */
static const char *set_path(const char *name)
{
  strncpy(path, name + 2, sizeof path - 1);
  return name;
}

enum { NOT_LOADED = -2000 };                                 /* not a status of NetCDF */

static void *entry(const char *name)
{
  static void *library;
  if (!library) library = dlopen(NETCDF_PATH, RTLD_LAZY);
  if (!library) library = dlopen(NETCDF_NAME, RTLD_LAZY);
  return library ? dlsym(library, name) : NULL;
}

#define CALL(name, parameters, arguments) \
  int bw_##name parameters \
  { \
    int (*real) parameters, status = NOT_LOADED; \
    *(void **)&real = entry(#name); \
    bw_let_library_read(path); \
    if (real) status = real arguments; \
    bw_let_library_read(NULL); \
    return status; \
  }

CALL(nc_open, (const char *name, int mode, int *file), (set_path(name), mode, file))
CALL(nc_close, (int file), (file))
CALL(nc_inq_format, (int file, int *format), (file, format))
CALL(nc_inq, (int file, int *dimensions, int *variables, int *attributes, int *unlimited),
     (file, dimensions, variables, attributes, unlimited))
CALL(nc_inq_dim, (int file, int dimension, char *name, size_t *length), (file, dimension, name, length))
CALL(nc_inq_varid, (int file, const char *name, int *variable), (file, name, variable))
CALL(nc_inq_varndims, (int file, int variable, int *rank), (file, variable, rank))
CALL(nc_inq_var, (int file, int variable, char *name, int *type, int *rank, int *dimensions, int *attributes),
     (file, variable, name, type, rank, dimensions, attributes))
CALL(nc_get_vara_double, (int file, int variable, const size_t *first, const size_t *count, double *values),
     (file, variable, first, count, values))
CALL(nc_inq_att, (int file, int variable, const char *name, int *type, size_t *length), (file, variable, name, type, length))
CALL(nc_get_att_double, (int file, int variable, const char *name, double *value), (file, variable, name, value))
CALL(nc_get_att_text, (int file, int variable, const char *name, char *text), (file, variable, name, text))
CALL(nc_get_att_string, (int file, int variable, const char *name, char **texts), (file, variable, name, texts))
CALL(nc_free_string, (size_t count, char **texts), (count, texts))

const char *bw_nc_strerror(int status)
{
  const char *(*real)(int);
  *(void **)&real = entry("nc_strerror");
  return real ? real(status) : "NetCDF's library cannot be loaded: " NETCDF_PATH;
}
