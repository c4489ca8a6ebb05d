/* System functions that Fortran lacks, by the system's own headers: files, locks, processes, signals.
   bw_system_calls.f90 has the Fortran interfaces. Unless said otherwise a function returns 0, or the system's error number;
   calls interrupted by a signal are repeated. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <poll.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/time.h>
#include <sys/types.h>
#include <unistd.h>

#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
#define HIGH_FIRST(word, bits) (word)
#else
#define HIGH_FIRST(word, bits) __builtin_bswap##bits(word)
#endif
#define AGAIN_WHERE_INTERRUPTED(call) \
  do { errno = 0; } while ((call) < 0 && errno == EINTR)

/* ---- errors ------------------------------------------------------------------------------------------------------- */

/* Kinds of errors: the numbers are those of bw_system_calls.f90. */
int bw_kind_of_error(int number)
{
  switch (number) {
  case ENOENT: case ENOTDIR: return 1;                       /* the name does not exist */
  case EEXIST: case ENOTEMPTY: return 2;                     /* the name exists */
  case EWOULDBLOCK: return 3;                                /* another process holds it */
  case ENOSYS: case ENOLCK: case EOPNOTSUPP: case EINVAL: case EPERM: case EMLINK: return 4;  /* not supported by this file system */
  case EPIPE: return 5;                                      /* the reader has closed the pipe */
  default: return 0;
  }
}

void bw_error_text(int number, char *text, int length)
{
  snprintf(text, (size_t)length, "%s", strerror(number));
}

/* ---- files by descriptors ------------------------------------------------------------------------------------------ */

/* Open without truncation, and without waiting for a pipe or a device: the caller checks what it is. */
int bw_open(const char *path, int way, int *descriptor)
{
  const int always = O_CLOEXEC | O_NONBLOCK | O_NOCTTY;
  const int flags[] = {0, O_RDONLY, O_RDWR | O_CREAT | O_EXCL, O_RDWR | O_NOFOLLOW};
  AGAIN_WHERE_INTERRUPTED(*descriptor = open(path, flags[way] | always, 0666));
  return *descriptor < 0 ? errno : 0;
}

/* An interrupted close is complete. */
int bw_close(int descriptor)
{
  return close(descriptor) < 0 && errno != EINTR ? errno : 0;
}

/* Read up to `count` bytes. */
int bw_read(int descriptor, void *bytes, int64_t count, int64_t offset, int64_t *have)
{
  for (*have = 0; *have < count;) {
    ssize_t more;
    AGAIN_WHERE_INTERRUPTED(more = pread(descriptor, (char *)bytes + *have, (size_t)(count - *have), offset + *have));
    if (more < 0) return errno;
    if (more == 0) break;
    *have += more;
  }
  return 0;
}

/* Write all bytes; wait while a stream is full. */
int bw_write(int descriptor, const void *bytes, int64_t count)
{
  for (int64_t have = 0; have < count;) {
    ssize_t more;
    AGAIN_WHERE_INTERRUPTED(more = write(descriptor, (const char *)bytes + have, (size_t)(count - have)));
    if (more < 0 && errno == EAGAIN) {
      struct pollfd stream = {descriptor, POLLOUT, 0};
      poll(&stream, 1, 1000);
    } else if (more <= 0) {
      return more < 0 ? errno : EIO;
    } else {
      have += more;
    }
  }
  return 0;
}

/* Read from a pipe, waiting up to so many milliseconds: return the number of bytes, 0 at its end, −1 if there are none yet. */
int64_t bw_listen(int channel, void *bytes, int64_t most, int milliseconds)
{
  struct pollfd stream = {channel, POLLIN, 0};
  ssize_t have;
  if (poll(&stream, 1, milliseconds) <= 0) return -1;
  AGAIN_WHERE_INTERRUPTED(have = read(channel, bytes, (size_t)most));
  return have < 0 ? 0 : have;
}

/* Flush a file to the disk, so that it survives a crash of the machine. */
int bw_flush(int descriptor)
{
  int result;
  AGAIN_WHERE_INTERRUPTED(result = fdatasync(descriptor));
  return result < 0 ? errno : 0;
}

/* Kind (1 file, 2 directory, 3 something else), device, inode, links, bytes of an open file; if the descriptor is below 0, of a path:
   of a link itself, or of its target. */
int bw_look_at(int descriptor, const char *path, int itself, int64_t state[5])
{
  struct stat found;
  if ((descriptor >= 0 ? fstat(descriptor, &found) : (itself ? lstat : stat)(path, &found)) < 0) return errno;
  state[0] = S_ISREG(found.st_mode) ? 1 : S_ISDIR(found.st_mode) ? 2 : 3;
  state[1] = (int64_t)found.st_dev;
  state[2] = (int64_t)found.st_ino;
  state[3] = (int64_t)found.st_nlink;
  state[4] = (int64_t)found.st_size;
  return 0;
}

/* ---- numbers at known offsets ----------------------------------------------------------------------------------------- */

/* Set the length of a file, and reserve disk space for its first bytes, so that a full disk is detected now, if the file system
   supports that. */
int bw_reserve(int descriptor, int64_t reserved, int64_t bytes)
{
  int result;
#ifdef __linux__
  AGAIN_WHERE_INTERRUPTED(result = fallocate(descriptor, 0, 0, reserved));
#else
  result = (errno = posix_fallocate(descriptor, 0, reserved)) ? -1 : 0;
#endif
  if (result < 0 && errno != EOPNOTSUPP && errno != ENOSYS && errno != EINVAL) return errno;
  AGAIN_WHERE_INTERRUPTED(result = ftruncate(descriptor, bytes));
  return result < 0 ? errno : 0;
}

static int write_at(int descriptor, const char *bytes, int64_t count, int64_t place)
{
  for (int64_t have = 0; have < count;) {
    ssize_t more;
    AGAIN_WHERE_INTERRUPTED(more = pwrite(descriptor, bytes + have, (size_t)(count - have), place + have));
    if (more <= 0) return more < 0 ? errno : EIO;
    have += more;
  }
  return 0;
}

/* A file of numbers at known offsets. Consecutive numbers are gathered before they are written. While a process
   holds the file, numbers of other processes between its own are read, and written back with them: that is
   faster than writing rows of less than a page one by one, and a mapping would have every process fault every page. */
typedef struct {
  int descriptor, is_held;
  int64_t place, count;                                      /* of the gathered bytes */
  int64_t known;                                             /* these, and bytes of the file that follow */
  char bytes[1 << 18];
} number_file;

/* The caller frees the result. */
int bw_open_numbers(int descriptor, number_file **file)
{
  number_file *made = *file = malloc(sizeof *made);
  if (!made) return ENOMEM;
  made->descriptor = descriptor;
  made->place = made->count = made->known = made->is_held = 0;
  return 0;
}

/* Wait until the file is free, and hold it until the numbers put from now on are written. */
int bw_hold(number_file *file)
{
  int result;
  AGAIN_WHERE_INTERRUPTED(result = flock(file->descriptor, LOCK_EX));
  file->is_held = result == 0;
  return result < 0 ? errno : 0;
}

static int write_bytes(number_file *file)
{
  int64_t count = file->count;
  file->count = file->known = 0;
  return count ? write_at(file->descriptor, file->bytes, count, file->place) : 0;
}

/* Write the gathered bytes, and release the file. */
int bw_write_gathered(number_file *file)
{
  int number = write_bytes(file);
  if (file->is_held) flock(file->descriptor, LOCK_UN);
  file->is_held = 0;
  return number;
}

/* Gather bytes of the file up to an offset: 0 if that is too far. */
static int is_filled_up(number_file *file, int64_t place, int64_t width)
{
  const int64_t page = 4096, piece = 1 << 15, most = sizeof file->bytes, to = place - file->place;
  int64_t have = 0;
  if (!file->is_held || !file->count || to <= file->count || to - file->count >= page || to + width > most) return 0;
  for (; file->known < to; file->known += have) {
    int64_t left = most - file->known;
    int number = bw_read(file->descriptor, file->bytes + file->known, left < piece ? left : piece, file->place + file->known, &have);
    if (number || !have) return 0;
  }
  file->count = to;
  return 1;
}

/* Return room for the next numbers, at least for one; NULL if the gathered bytes cannot be written. */
static char *room_for(number_file *file, int64_t place, int64_t count, int64_t width, int64_t *room, int *number)
{
  const int64_t most = sizeof file->bytes;
  *number = 0;
  if (!is_filled_up(file, place, width) && (place != file->place + file->count || file->count + width > most)) {
    if ((*number = write_bytes(file))) return NULL;
    file->place = place;
  }
  *room = count < most - file->count ? count : most - file->count;
  *room -= *room % width;
  file->count += *room;
  if (file->known < file->count) file->known = file->count;
  return file->bytes + file->count - *room;
}

/* Copy words of eight bytes, converting between native and big-endian order. */
static void copy_words(void *restrict to, const void *restrict from, int64_t count)
{
  for (int64_t i = 0; i < 8 * count; i += 8) {
    uint64_t word;
    memcpy(&word, (const char *)from + i, 8);
    word = HIGH_FIRST(word, 64);
    memcpy((char *)to + i, &word, 8);
  }
}

/* Put reals in big-endian order: eight bytes each, or as integers of four. With a width of 1, letters. */
int bw_put(number_file *file, int64_t place, int width, const void *values, int64_t count)
{
  const int64_t wide = width == 1 ? 1 : sizeof(double);
  const char *from = values;
  int number;
  for (int64_t room; count > 0; place += room, from += room / width * wide, count -= room / width) {
    char *to = room_for(file, place, count * width, width, &room, &number);
    if (!to) return number;
    if (width == 1) memcpy(to, from, (size_t)room);
    if (width == 8) copy_words(to, from, room / 8);
    for (int64_t i = 0; width == 4 && i < room / 4; i++) {
      uint32_t word = (uint32_t)(int32_t)((const double *)(const void *)from)[i];
      word = HIGH_FIRST(word, 32);
      memcpy(to + 4 * i, &word, 4);
    }
  }
  return 0;
}

/* Get numbers written by this process or another. */
int bw_get_numbers(number_file *file, int64_t place, int width, double *values, int64_t count)
{
  char piece[8192];
  int64_t have = 0;
  int number = bw_write_gathered(file);
  for (int64_t n; !number && count > 0; place += n * width, values += n, count -= n) {
    n = count < 8192 / width ? count : 8192 / width;
    number = bw_read(file->descriptor, piece, n * width, place, &have);
    if (!number && have < n * width) number = EIO;
    if (number) break;
    if (width == 8) copy_words(values, piece, n);
    for (int64_t i = 0; width == 4 && i < n; i++) {
      uint32_t word;
      memcpy(&word, piece + 4 * i, 4);
      values[i] = (int32_t)HIGH_FIRST(word, 32);
    }
  }
  return number;
}

/* ---- files by name ------------------------------------------------------------------------------------------------- */

static int flush_names(const char *directory)
{
  int descriptor, number;
  AGAIN_WHERE_INTERRUPTED(descriptor = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor < 0) return errno == EACCES ? 0 : errno;    /* impossible without permission to read */
  AGAIN_WHERE_INTERRUPTED(number = fsync(descriptor));
  number = number < 0 && errno != EINVAL && errno != EBADF ? errno : 0;       /* not supported by some file systems */
  bw_close(descriptor);
  return number;
}

/* Operations by name: the numbers are those of bw_system_calls.f90. */
int bw_do(int what, const char *path, const char *to)
{
  int result = -1;
  errno = EINVAL;
  switch (what) {
  case 1: result = unlink(path); break;
  case 2: result = mkdir(path, 0777); break;
  case 3: result = rmdir(path); break;
  case 4: result = faccessat(AT_FDCWD, path, W_OK | X_OK, AT_EACCESS); break;
  case 5: return flush_names(path);
  case 6: result = rename(path, to); break;
  case 7: result = link(path, to); break;
  }
  return result < 0 ? errno : 0;
}

/* List the names in a directory with a suffix, without hidden ones, sorted, each followed by NUL; the caller frees the list. */
int bw_list(const char *path, const char *suffix, char **text, int64_t *length)
{
  struct dirent **entries;
  size_t total = 1, tail = strlen(suffix);
  int count = scandir(path, &entries, NULL, alphasort);
  *length = 0;
  *text = NULL;
  if (count < 0) return errno;
  for (int i = 0; i < count; i++) total += strlen(entries[i]->d_name) + 1;
  *text = malloc(total);
  for (int i = 0; i < count; i++) {
    const char *name = entries[i]->d_name;
    size_t letters = strlen(name);
    if (*text && name[0] != '.' && letters >= tail && !strcmp(name + letters - tail, suffix)) {
      memcpy(*text + *length, name, letters + 1);
      *length += (int64_t)letters + 1;
    }
    free(entries[i]);
  }
  free(entries);
  return *text ? 0 : ENOMEM;
}

/* ---- locks and their holders ----------------------------------------------------------------------------------------- */

/* Take a lock without waiting; a read lock is shared. */
int bw_lock(int descriptor, int reading)
{
  int result;
  AGAIN_WHERE_INTERRUPTED(result = flock(descriptor, (reading ? LOCK_SH : LOCK_EX) | LOCK_NB));
  return result < 0 ? errno : 0;
}

void bw_host(char *name, int length)
{
  if (gethostname(name, (size_t)length) < 0) snprintf(name, (size_t)length, "unknown");
  name[length - 1] = 0;
}

int64_t bw_process(void) { return (int64_t)getpid(); }

/* Return the start of a process of this machine, in the system's ticks, which tells it from a later one of the same number;
   0: unknown; below 0: it does not exist. A process that may not be signalled counts as existing. */
int64_t bw_beginning_of(int64_t process)
{
  char path[64], line[1024];
  unsigned long long ticks = 0;
  snprintf(path, sizeof path, "/proc/%lld/stat", (long long)process);
  if (kill((pid_t)process, 0) < 0 && errno == ESRCH) return -1;
  FILE *file = fopen(path, "re");
  if (!file) return 0;
  if (fgets(line, sizeof line, file)) {
    char *place = strrchr(line, ')');                        /* the name in parentheses may contain any letter */
    if (place) sscanf(place + 1, " %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %*u %*u %*d %*d %*d %*d %*d %*d %llu", &ticks);
  }
  fclose(file);
  return (int64_t)ticks;
}

/* ---- end of this process --------------------------------------------------------------------------------------------- */

enum { OF_FAULT, OF_MEMORY, OF_STACK, OF_STOP, OF_FILE };

/* Messages of abnormal endings, and their statuses, which are those of bw_error.f90. */
static const struct { const char *message; int status; } endings[] = {
  {"a fault in the program: please report it\n", 70},
  {"not enough memory\n", 3},
  {"the stack is exhausted; accepted: a larger one (ulimit -s)\n", 3},
  {"stopped within a step that could not be left in order; finished cases are saved\n", 5},
  {": cannot be read: the library that reads it crashed or found no end: the file is damaged, or memory ran out\n", 3}};

static const int faults[] = {SIGILL, SIGABRT, SIGBUS, SIGFPE, SIGSEGV}, stops[] = {SIGINT, SIGTERM, SIGUSR1, SIGXCPU, SIGHUP};
static volatile sig_atomic_t received, time_is_up, is_unseen;
static const char *file_of_library;                          /* being read by a library; NULL: none */
static const char *stack_top;
static uint64_t stack_room;                                  /* bytes kept free below it */

/* Nothing here may allocate, as the heap may be corrupt. */
static void say(const char *text)
{
  if (write(STDERR_FILENO, text, strlen(text)) < 0) return;
}

static void end_at_once(int ending)
{
  say(ending == OF_FILE ? file_of_library : "beamwave: ");
  say(endings[ending].message);
  _exit(endings[ending].status);
}

/* Set the processor time until the process ends at once: short until the program checks for a stop, then longer to stop in order. */
static void watch_stop(int seconds)
{
  setitimer(ITIMER_PROF, &(struct itimerval){{0, 0}, {seconds, 0}}, NULL);
}

static void ask_to_stop(void)
{
  is_unseen = 1;
  watch_stop(1);
}

static void on_stop(int number)
{
  if (received) _exit(128 + number);                         /* a second signal ends the process at once */
  received = number;
  ask_to_stop();
}

static void on_time(int number)
{
  (void)number;
  time_is_up = 1;
  ask_to_stop();
}

static void on_missed_stop(int number)
{
  (void)number;
  end_at_once(OF_STOP);
}

static void on_library_time(int number)
{
  (void)number;
  end_at_once(OF_FILE);
}

/* A fault is blamed on the file that a library is reading, on a stack overflow if its address is just below the stack, or on refused
   memory if that was just before. */
static void on_fault(int number, siginfo_t *fault, void *unused)
{
  uint64_t below = (uint64_t)(uintptr_t)stack_top - (uint64_t)(uintptr_t)fault->si_addr;
  int is_of_stack = (number == SIGSEGV || number == SIGBUS) && fault->si_code > 0 && below < stack_room;
  (void)unused;
  end_at_once(file_of_library ? OF_FILE : is_of_stack ? OF_STACK : errno == ENOMEM ? OF_MEMORY : OF_FAULT);
}

/* Libraries exit with 1 or −1 if memory is refused (Fortran's, FFTW; HDF5); Fortran's exits with 2 after run-time errors. */
#ifdef __GLIBC__
static void on_end(int status, void *unused)
{
  (void)unused;
  end_at_once(file_of_library ? OF_FILE : status == 1 || status == -1 || status == 255 ? OF_MEMORY : OF_FAULT);
}
#else
static void on_end(void) { end_at_once(errno == ENOMEM ? OF_MEMORY : OF_FAULT); }
#define on_exit(handler, unused) atexit(handler)
#endif

/* Open closed standard streams to /dev/null, as the first opened file would take their place. */
void bw_open_standard_streams(void)
{
  for (int stream = 0; stream <= 2; stream++)
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", stream ? O_WRONLY : O_RDONLY) < 0) return;
}

/* Raise the stack limit as far as allowed, and store the stack's place. The system keeps 128 MB below it free. */
static void widen_stack(const char *top)
{
  const rlim_t enough = 64 << 20, kept_free = 128 << 20;
  struct rlimit limit;
  stack_top = top;
  stack_room = kept_free;
  if (getrlimit(RLIMIT_STACK, &limit) < 0) return;
  if (limit.rlim_cur < enough) {                             /* RLIM_INFINITY is the largest number */
    limit.rlim_cur = limit.rlim_max < enough ? limit.rlim_max : enough;
    setrlimit(RLIMIT_STACK, &limit);
  }
  if (limit.rlim_cur > kept_free && limit.rlim_cur != RLIM_INFINITY) stack_room = limit.rlim_cur;
}

/* Keep freed memory for the next case, as glibc does once a large block was freed: until then the end of the heap may be
   returned to the system and allocated again in each case. */
static void keep_memory(void)
{
#ifdef __GLIBC__
  const int most_of_heap = 32 << 20;                         /* of one piece; the largest that glibc would choose */
  mallopt(M_MMAP_THRESHOLD, most_of_heap);
  mallopt(M_TRIM_THRESHOLD, 2 * most_of_heap);
#endif
}

/* Install handlers of signals and abnormal endings. Call this once, before any work. */
void bw_watch(void)
{
  static char room[65536];
  const stack_t stack = {.ss_sp = room, .ss_size = sizeof room};
  struct sigaction action = {.sa_handler = on_stop, .sa_flags = SA_RESTART};
  on_exit(on_end, NULL);
  for (size_t i = 0; i < sizeof stops / sizeof *stops; i++) {
    struct sigaction before;
    sigaction(stops[i], NULL, &before);
    if (stops[i] != SIGHUP || before.sa_handler != SIG_IGN) sigaction(stops[i], &action, NULL);       /* `nohup` ignores it */
  }
  action.sa_handler = on_time;
  sigaction(SIGALRM, &action, NULL);
  action.sa_handler = on_missed_stop;
  sigaction(SIGPROF, &action, NULL);
  action.sa_handler = on_library_time;
  sigaction(SIGVTALRM, &action, NULL);
  widen_stack(__builtin_frame_address(0));
  keep_memory();
  sigaltstack(&stack, NULL);                                 /* for a stack overflow */
  action = (struct sigaction){.sa_sigaction = on_fault, .sa_flags = SA_ONSTACK | SA_SIGINFO};
  for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) sigaction(faults[i], &action, NULL);
  signal(SIGXFSZ, SIG_IGN);                                  /* `ulimit -f`: the write fails, as on a full disk */
  signal(SIGPIPE, SIG_IGN);                                  /* the reader has closed the pipe: the write fails */
}

/* Register the file that a library reads, with a time limit; NULL: it has returned. */
void bw_let_library_read(const char *path)
{
  const int most = 5;                                        /* s, a hundred times the slowest decompression */
  file_of_library = path;
  setitimer(ITIMER_VIRTUAL, &(struct itimerval){{0, 0}, {path ? most : 0, 0}}, NULL);
}

/* Request a stop after so many seconds. */
void bw_stop_after(double seconds)
{
  const double most = 1e9;
  struct itimerval span = {{0, 0}, {0, 0}};
  if (seconds > most) seconds = most;
  span.it_value.tv_sec = (time_t)seconds;
  span.it_value.tv_usec = (suseconds_t)(1e6 * (seconds - (double)span.it_value.tv_sec));
  time_is_up = seconds < 1e-6;
  if (!time_is_up) setitimer(ITIMER_REAL, &span, NULL);
}

/* Return whether a signal or the time limit requests a stop. A program that checks gets time to stop in order. */
int bw_stop_asked(void)
{
  if (is_unseen) watch_stop(10);
  is_unseen = 0;
  return received || time_is_up;
}

/* ---- machine and terminal ---------------------------------------------------------------------------------------------- */

void bw_pause(int microseconds) { usleep((useconds_t)microseconds); }

/* Return the free disk space for this user at a path, bytes; below 0: unknown. */
int64_t bw_free_disk(const char *path)
{
  struct statvfs found;
  int result;
  AGAIN_WHERE_INTERRUPTED(result = statvfs(path, &found));
  if (result < 0) return -1;
  if (found.f_bavail > (uint64_t)INT64_MAX / (found.f_frsize ? found.f_frsize : 1)) return INT64_MAX;
  return (int64_t)(found.f_bavail * found.f_frsize);
}

/* Return the memory available without swapping, bytes; if unknown, the whole memory. Below 0:
   unknown. */
int64_t bw_free_memory(void)
{
  long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
  long long kilobytes = -1;
  char line[128];
  FILE *told = fopen("/proc/meminfo", "re");
  while (told && kilobytes < 0 && fgets(line, sizeof line, told)) sscanf(line, "MemAvailable: %lld kB", &kilobytes);
  if (told) fclose(told);
  if (kilobytes >= 0) return (int64_t)kilobytes * 1024;
  return pages < 0 || size < 0 ? -1 : (int64_t)pages * size;
}

/* If LAPACK is OpenBLAS, set it to one thread, and let it allocate the memory of its first call now, so many bytes:
   if that were refused later, it would retry endlessly. ENOMEM: it is refused. */
int bw_prepare_openblas(int64_t bytes)
{
  void (*set_threads)(int);
  void (*dsyrk)(const char *, const char *, const int *, const int *, const double *, const double *, const int *, const double *,
                double *, const int *, size_t, size_t);
  const int one = 1;
  const double number = 1.0;
  double sum = 0.0;
  *(void **)&set_threads = dlsym(RTLD_DEFAULT, "openblas_set_num_threads");
  *(void **)&dsyrk = dlsym(RTLD_DEFAULT, "dsyrk_");
  if (!set_threads || !dsyrk) return 0;
  void *room = mmap(NULL, (size_t)bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (room == MAP_FAILED) return ENOMEM;
  munmap(room, (size_t)bytes);
  set_threads(1);
  dsyrk("U", "N", &one, &one, &number, &number, &one, &number, &sum, &one, 1, 1);
  return 0;
}

/* An existing value is kept. */
void bw_set_environment(const char *name, const char *value) { setenv(name, value, 0); }
