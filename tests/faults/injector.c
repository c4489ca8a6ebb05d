/* Preloaded into a program (LD_PRELOAD), this makes the N-th call of a kind fail, or kills the process there. The calls of all
   processes of a run are counted together, in the order in which they come.

     BEAMWAVE_FAULT_COUNTS=FILE   the counts, one 64-bit integer for each kind, shared by the processes; made by the caller
     BEAMWAVE_FAULT_UNDER=DIR     only files under this directory count, and relative paths; malloc counts after the first of them
     BEAMWAVE_FAULT=KIND:N:WHAT   WHAT is an error's number; short, for a read or write of half the bytes; kill, to die instead of the
                                  call, or torn, in the middle of a write; a + before it: this call and all after it

   Kinds are those of `kinds` below. Only programs called beamwave… are concerned, not what starts them. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

enum { OPEN, FOPEN, READ, PREAD, WRITE, PWRITE, CLOSE, FSYNC, FDATASYNC, FALLOCATE, FTRUNCATE, MMAP, RENAME, LINK, UNLINK, MKDIR, RMDIR,
       OPENDIR, READDIR, STAT, FLOCK, FORK, MALLOC, KINDS };
static const char *const kinds[KINDS] = {"open", "fopen", "read", "pread", "write", "pwrite", "close", "fsync", "fdatasync", "fallocate",
  "ftruncate", "mmap", "rename", "link", "unlink", "mkdir", "rmdir", "opendir", "readdir", "stat", "flock", "fork", "malloc"};

static uint64_t *counts, at;
static const char *under = "";
static int kind = -1, number, for_good, is_short, is_kill, is_torn, is_ready, is_armed;

static void get_ready(void)
{
  const char *text;
  char name[16] = "", what[16] = "";
  if (is_ready) return;
  is_ready = 1;
  if (strncmp(program_invocation_short_name, "beamwave", 8)) return;
  if ((text = getenv("BEAMWAVE_FAULT_UNDER"))) under = text;
  if ((text = getenv("BEAMWAVE_FAULT_COUNTS"))) {
    int file = (int)syscall(SYS_openat, AT_FDCWD, text, O_RDWR, 0);
    void *memory = mmap(NULL, KINDS * sizeof *counts, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (memory != MAP_FAILED) counts = memory;
    syscall(SYS_close, file);
  }
  if (!(text = getenv("BEAMWAVE_FAULT"))) return;
  unsigned long long place = 0;
  if (sscanf(text, "%15[a-z]:%llu:%15s", name, &place, what) < 3) return;
  for_good = what[0] == '+';
  at = place;
  text = what + for_good;
  for (int i = 0; i < KINDS; i++) if (!strcmp(kinds[i], name)) kind = i;
  is_short = !strcmp(text, "short");
  is_kill = !strcmp(text, "kill");
  is_torn = !strcmp(text, "torn");
  number = atoi(text);
}

/* Count a call; true where it is to fail. */
static int fails(int which)
{
  get_ready();
  if (!counts) return 0;
  uint64_t count = __atomic_add_fetch(&counts[which], 1, __ATOMIC_SEQ_CST);
  if (which != kind || !(count == at || (for_good && count > at))) return 0;
  if (is_kill) raise(SIGKILL);
  errno = number;
  return 1;
}

static int path_counts(const char *path)
{
  get_ready();
  int is_ours = path && (path[0] != '/' || strstr(path, under));
  if (is_ours) is_armed = 1;
  return is_ours;
}

static int file_counts(int descriptor)
{
  char link[64], path[4096];
  int before = errno;
  get_ready();
  snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  ssize_t length = readlink(link, path, sizeof path - 1);
  errno = before;
  if (length < 0) return 0;
  path[length] = 0;
  return path[0] == '/' && strstr(path, under);
}

#define REAL(type, name, ...) \
  static type (*real)(__VA_ARGS__); \
  if (!real) *(void **)&real = dlsym(RTLD_NEXT, #name)

#define OPENS(name) \
  int name(const char *path, int flags, ...) \
  { \
    REAL(int, name, const char *, int, ...); \
    va_list rest; \
    va_start(rest, flags); \
    mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0; \
    va_end(rest); \
    if (path_counts(path) && fails(OPEN)) return -1; \
    return real(path, flags, mode); \
  }
OPENS(open)
OPENS(open64)

FILE *fopen(const char *path, const char *mode)
{
  REAL(FILE *, fopen, const char *, const char *);
  return path_counts(path) && fails(FOPEN) ? NULL : real(path, mode);
}

FILE *fopen64(const char *path, const char *mode)
{
  REAL(FILE *, fopen64, const char *, const char *);
  return path_counts(path) && fails(FOPEN) ? NULL : real(path, mode);
}

/* Of a call that moves bytes: how many, or −1. */
static ssize_t moved(int which, int descriptor, size_t *count)
{
  if (!file_counts(descriptor) || !fails(which)) return 0;
  if (!is_short && !is_torn) return -1;
  *count = (*count + 1) / 2;
  return is_torn;
}

#define MOVES(name, which, type) \
  ssize_t name(int descriptor, type bytes, size_t count) \
  { \
    REAL(ssize_t, name, int, type, size_t); \
    ssize_t verdict = moved(which, descriptor, &count); \
    if (verdict < 0) return -1; \
    ssize_t result = real(descriptor, bytes, count); \
    if (verdict > 0) raise(SIGKILL); \
    return result; \
  }
MOVES(read, READ, void *)
MOVES(write, WRITE, const void *)

#define MOVES_AT(name, which, type) \
  ssize_t name(int descriptor, type bytes, size_t count, off_t place) \
  { \
    REAL(ssize_t, name, int, type, size_t, off_t); \
    ssize_t verdict = moved(which, descriptor, &count); \
    if (verdict < 0) return -1; \
    ssize_t result = real(descriptor, bytes, count, place); \
    if (verdict > 0) raise(SIGKILL); \
    return result; \
  }
MOVES_AT(pread, PREAD, void *)
MOVES_AT(pread64, PREAD, void *)
MOVES_AT(pwrite, PWRITE, const void *)
MOVES_AT(pwrite64, PWRITE, const void *)

int close(int descriptor)
{
  REAL(int, close, int);
  if (file_counts(descriptor) && fails(CLOSE)) {
    int before = errno;
    real(descriptor);                    /* as on NFS: it is closed, and what was written is lost */
    errno = before;
    return -1;
  }
  return real(descriptor);
}


int fsync(int descriptor)
{
  REAL(int, fsync, int);
  return file_counts(descriptor) && fails(FSYNC) ? -1 : real(descriptor);
}

int fdatasync(int descriptor)
{
  REAL(int, fdatasync, int);
  return file_counts(descriptor) && fails(FDATASYNC) ? -1 : real(descriptor);
}

#define ALLOCATES(name, type) \
  int name(int descriptor, int mode, type first, type length) \
  { \
    REAL(int, name, int, int, type, type); \
    return file_counts(descriptor) && fails(FALLOCATE) ? -1 : real(descriptor, mode, first, length); \
  }
ALLOCATES(fallocate, off_t)
ALLOCATES(fallocate64, off64_t)

#define MAPS(name, type) \
  void *name(void *address, size_t length, int protection, int flags, int descriptor, type place) \
  { \
    REAL(void *, name, void *, size_t, int, int, int, type); \
    if (descriptor >= 0 && file_counts(descriptor) && fails(MMAP)) return MAP_FAILED; \
    return real(address, length, protection, flags, descriptor, place); \
  }
MAPS(mmap, off_t)
MAPS(mmap64, off64_t)

int flock(int descriptor, int operation)
{
  REAL(int, flock, int, int);
  return file_counts(descriptor) && fails(FLOCK) ? -1 : real(descriptor, operation);
}

int ftruncate(int descriptor, off_t length)
{
  REAL(int, ftruncate, int, off_t);
  return file_counts(descriptor) && fails(FTRUNCATE) ? -1 : real(descriptor, length);
}

int ftruncate64(int descriptor, off_t length)
{
  REAL(int, ftruncate64, int, off_t);
  return file_counts(descriptor) && fails(FTRUNCATE) ? -1 : real(descriptor, length);
}

#define OF_TWO_PATHS(name, which) \
  int name(const char *from, const char *to) \
  { \
    REAL(int, name, const char *, const char *); \
    return path_counts(from) && fails(which) ? -1 : real(from, to); \
  }
OF_TWO_PATHS(rename, RENAME)
OF_TWO_PATHS(link, LINK)

#define OF_PATH(name, which) \
  int name(const char *path) \
  { \
    REAL(int, name, const char *); \
    return path_counts(path) && fails(which) ? -1 : real(path); \
  }
OF_PATH(unlink, UNLINK)
OF_PATH(rmdir, RMDIR)

int mkdir(const char *path, mode_t mode)
{
  REAL(int, mkdir, const char *, mode_t);
  return path_counts(path) && fails(MKDIR) ? -1 : real(path, mode);
}

int stat(const char *path, struct stat *found)
{
  REAL(int, stat, const char *, struct stat *);
  return path_counts(path) && fails(STAT) ? -1 : real(path, found);
}

DIR *opendir(const char *path)
{
  REAL(DIR *, opendir, const char *);
  return path_counts(path) && fails(OPENDIR) ? NULL : real(path);
}

struct dirent *readdir(DIR *directory)
{
  REAL(struct dirent *, readdir, DIR *);
  return file_counts(dirfd(directory)) && fails(READDIR) ? NULL : real(directory);
}

pid_t fork(void)
{
  REAL(pid_t, fork, void);
  return is_armed && fails(FORK) ? -1 : real();
}

/* The heap is asked for before anything can be looked up. */
extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);

void *malloc(size_t bytes) { return is_armed && fails(MALLOC) ? NULL : __libc_malloc(bytes); }
void *calloc(size_t count, size_t bytes) { return is_armed && fails(MALLOC) ? NULL : __libc_calloc(count, bytes); }
void *realloc(void *memory, size_t bytes) { return is_armed && fails(MALLOC) ? NULL : __libc_realloc(memory, bytes); }
