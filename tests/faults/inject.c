/* Preloaded before a program: makes the n-th call of a kind fail, or ends the process there. Linux with glibc; no dependency.

   HVI_FAULT = KIND,N,MODE,ERRNO
     alloc open read write print rename fsync close remove folder thread
                  the N-th call of the kind (from 1) fails; MODE `once`, or `on`: so do all after it
     kill         SIGKILL before the N-th change of the disk (a file made, written, renamed, synced, removed); MODE `half`: in the
                  middle of it where it is a write
     loss         the same with the power lost: what was written and not synced is cut away, renames whose folder was not synced are
                  undone; with ERRNO 1 they came through before what they name.
                  MODE: the number of an fsync that only pretended; 0: none
     N = 0 counts only.
   HVI_FAULT_COUNTS = FILE   at the end of the program: how many calls of each kind there were, a line each
   HVI_FAULT_UNDO = FOLDER   for `loss`: where the old files of renames are kept, on the same disk

   Children of the program are left alone. The calls that count are those of the program itself: what libc does inside stdio is seen
   by `print`, which takes the standard output's file away. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

enum kind { ALLOC, OPEN, READ, WRITE, PRINT, RENAME, FSYNC, CLOSE, REMOVE, FOLDER, THREAD, KILL, LOSS, KINDS };
static const char *const names[KINDS] = {"alloc", "open",  "read",   "write",  "print", "rename", "fsync",
                                         "close", "remove", "folder", "thread", "kill",  "loss"};

static atomic_long counts[KINDS];
static int active;             /* the program has begun, and we are in it */
static int kind = -1, on, half, error_number;
static long wanted, pretended; /* pretended: the fsync that did nothing */
static pid_t owner;
static char counts_file[4096], undo_folder[4096];

/* What we stand in front of where there is no system call to take its place. */
static __typeof__(fopen64) *real_fopen;
static __typeof__(opendir) *real_opendir;
static __typeof__(fwrite) *real_fwrite;
static __typeof__(fputs) *real_fputs;
static __typeof__(fflush) *real_fflush;
static __typeof__(pthread_create) *real_pthread_create;

static void *next(const char *name) {
  void *const out = dlsym(RTLD_NEXT, name);
  if (!out) abort();
  return out;
}

/* Is this the call that fails? A place for a debugger to stop at. */
__attribute__((noinline)) int hvi_injected(void) {
  errno = error_number;
  return 1;
}

static int fails(enum kind of) {
  if (!active) return 0;
  const long i = atomic_fetch_add(&counts[of], 1) + 1;
  if (kind != (int)of || wanted == 0 || !(i == wanted || (on && i > wanted))) return 0;
  return hvi_injected();
}

/* --- what a loss of power takes away --- */

struct file { /* written to: its inode, a descriptor of our own, and what is safe of it */
  dev_t device;
  ino_t inode;
  int descriptor;
  off_t safe;
};
struct renaming {
  dev_t device; /* of the folder */
  ino_t inode;
  char path[1024], kept[1024]; /* kept: the old file, or empty */
};
static struct file files[4096];
static struct renaming renamings[4096];
static int file_count, renaming_count;
static pthread_mutex_t guard = PTHREAD_MUTEX_INITIALIZER;

static struct file *file_of(int descriptor) {
  struct stat s;
  if (fstat(descriptor, &s) != 0 || !S_ISREG(s.st_mode)) return NULL;
  for (int i = 0; i < file_count; ++i)
    if (files[i].device == s.st_dev && files[i].inode == s.st_ino) return &files[i];
  if (file_count == (int)(sizeof files / sizeof *files)) abort();
  char path[64];
  snprintf(path, sizeof path, "/proc/self/fd/%d", descriptor);
  struct file *f = &files[file_count++];
  f->device = s.st_dev;
  f->inode = s.st_ino;
  f->safe = s.st_size; /* from before */
  f->descriptor = (int)syscall(SYS_openat, AT_FDCWD, path, O_RDWR | O_CLOEXEC);
  return f;
}

static void note_write(int descriptor) {
  if (kind != LOSS) return;
  pthread_mutex_lock(&guard);
  file_of(descriptor);
  pthread_mutex_unlock(&guard);
}

static void note_sync(int descriptor) {
  struct stat s;
  if (kind != LOSS || atomic_load(&counts[FSYNC]) == pretended || fstat(descriptor, &s) != 0) return;
  pthread_mutex_lock(&guard);
  if (S_ISREG(s.st_mode)) {
    struct file *f = file_of(descriptor);
    if (f) f->safe = s.st_size;
  }
  int left = 0;
  for (int i = 0; i < renaming_count; ++i)
    if (!S_ISDIR(s.st_mode) || renamings[i].device != s.st_dev || renamings[i].inode != s.st_ino) renamings[left++] = renamings[i];
  renaming_count = left;
  pthread_mutex_unlock(&guard);
}

static void note_rename(const char *to) {
  struct stat s;
  char folder[1024];
  if (kind != LOSS || renaming_count == (int)(sizeof renamings / sizeof *renamings)) return;
  snprintf(folder, sizeof folder, "%s", to);
  char *slash = strrchr(folder, '/');
  if (slash) *slash = '\0';
  if (stat(slash ? folder : ".", &s) != 0) return;
  pthread_mutex_lock(&guard);
  struct renaming *r = &renamings[renaming_count++];
  r->device = s.st_dev;
  r->inode = s.st_ino;
  snprintf(r->path, sizeof r->path, "%s", to);
  snprintf(r->kept, sizeof r->kept, "%.900s/%ld", undo_folder, atomic_load(&counts[RENAME]));
  if (link(to, r->kept) != 0) r->kept[0] = '\0';
  pthread_mutex_unlock(&guard);
}

static void lose_power(void) {
  for (int i = error_number ? -1 : renaming_count - 1; i >= 0; --i) {
    if (renamings[i].kept[0])
      syscall(SYS_renameat2, AT_FDCWD, renamings[i].kept, AT_FDCWD, renamings[i].path, 0);
    else
      syscall(SYS_unlinkat, AT_FDCWD, renamings[i].path, 0);
  }
  for (int i = 0; i < file_count; ++i) {
    struct stat s;
    if (fstat(files[i].descriptor, &s) == 0 && s.st_size > files[i].safe)
      syscall(SYS_ftruncate, files[i].descriptor, files[i].safe);
  }
}

static void end(void) {
  hvi_injected();
  if (kind == LOSS) lose_power();
  syscall(SYS_kill, getpid(), SIGKILL);
}

/* Before a change of the disk; true: the process ends in the middle of it. */
static int changes(void) {
  if (!active) return 0;
  const long i = atomic_fetch_add(&counts[KILL], 1) + 1;
  atomic_fetch_add(&counts[LOSS], 1);
  if ((kind != KILL && kind != LOSS) || i != wanted) return 0;
  if (half) return 1;
  end();
  return 1;
}

/* --- memory --- */

/* libc's own, which a program that stands in front of them calls by these names, and another by the standard ones. */
typedef void *(*takes_size)(size_t);
typedef void *(*takes_two)(size_t, size_t);
typedef void *(*takes_old)(void *, size_t);
static takes_size real_malloc;
static takes_two real_calloc, real_memalign;
static takes_old real_realloc;

static void find_memory(void) {
  real_calloc = (takes_two)next("__libc_calloc");
  real_realloc = (takes_old)next("__libc_realloc");
  real_memalign = (takes_two)next("__libc_memalign");
  real_malloc = (takes_size)next("__libc_malloc");
}

static void *take(size_t n) {
  if (!real_malloc) find_memory();
  return fails(ALLOC) ? NULL : real_malloc(n);
}
static void *take_zeros(size_t n, size_t size) {
  if (!real_malloc) find_memory();
  return fails(ALLOC) ? NULL : real_calloc(n, size);
}
static void *take_more(void *p, size_t n) {
  if (!real_malloc) find_memory();
  return n != 0 && fails(ALLOC) ? NULL : real_realloc(p, n);
}
static void *take_aligned(size_t unit, size_t n) {
  if (!real_malloc) find_memory();
  return fails(ALLOC) ? NULL : real_memalign(unit, n);
}

void *malloc(size_t n) { return take(n); }
void *calloc(size_t n, size_t size) { return take_zeros(n, size); }
void *realloc(void *p, size_t n) { return take_more(p, n); }
void *memalign(size_t unit, size_t n) { return take_aligned(unit, n); }
void *aligned_alloc(size_t unit, size_t n) { return take_aligned(unit, n); }
int posix_memalign(void **out, size_t unit, size_t n) {
  void *const p = take_aligned(unit, n);
  if (!p) return ENOMEM;
  *out = p;
  return 0;
}
void *__libc_malloc(size_t n) { return take(n); }
void *__libc_calloc(size_t n, size_t size) { return take_zeros(n, size); }
void *__libc_realloc(void *p, size_t n) { return take_more(p, n); }
void *__libc_memalign(size_t unit, size_t n) { return take_aligned(unit, n); }

/* --- files --- */

static int opened(int folder, const char *path, int flags, mode_t mode) {
  if (fails(OPEN)) return -1;
  if (flags & O_CREAT) changes();
  return (int)syscall(SYS_openat, folder, path, flags, mode);
}

#define MODE_OF(flags)                              \
  mode_t mode = 0;                                  \
  if (flags & (O_CREAT | __O_TMPFILE)) {            \
    va_list rest;                                   \
    va_start(rest, flags);                          \
    mode = va_arg(rest, mode_t);                    \
    va_end(rest);                                   \
  }

int open(const char *path, int flags, ...) {
  MODE_OF(flags)
  return opened(AT_FDCWD, path, flags, mode);
}
int open64(const char *path, int flags, ...) {
  MODE_OF(flags)
  return opened(AT_FDCWD, path, flags, mode);
}
int openat(int folder, const char *path, int flags, ...) {
  MODE_OF(flags)
  return opened(folder, path, flags, mode);
}
int openat64(int folder, const char *path, int flags, ...) {
  MODE_OF(flags)
  return opened(folder, path, flags, mode);
}
FILE *fopen64(const char *path, const char *how) {
  if (fails(OPEN)) return NULL;
  if (*how != 'r') changes();
  return real_fopen(path, how);
}
FILE *fopen(const char *path, const char *how) { return fopen64(path, how); }
DIR *opendir(const char *path) {
  return fails(OPEN) ? NULL : real_opendir(path);
}

ssize_t read(int descriptor, void *to, size_t n) {
  return fails(READ) ? -1 : syscall(SYS_read, descriptor, to, n);
}
ssize_t pread(int descriptor, void *to, size_t n, off_t at) {
  return fails(READ) ? -1 : syscall(SYS_pread64, descriptor, to, n, at);
}

/* A disk that fills up takes the first half. */
ssize_t write(int descriptor, const void *from, size_t n) {
  if (fails(WRITE)) {
    const int reason = errno;
    if (on && n > 1 && atomic_load(&counts[WRITE]) == wanted) return syscall(SYS_write, descriptor, from, n / 2);
    errno = reason;
    return -1;
  }
  note_write(descriptor);
  if (changes()) {
    syscall(SYS_write, descriptor, from, n / 2);
    end();
  }
  return syscall(SYS_write, descriptor, from, n);
}

int ftruncate(int descriptor, off_t n) {
  if (fails(WRITE)) return -1;
  note_write(descriptor);
  if (changes()) end();
  return (int)syscall(SYS_ftruncate, descriptor, n);
}

int rename(const char *from, const char *to) {
  if (fails(RENAME)) return -1;
  if (changes()) end();
  note_rename(to);
  return (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

int fsync(int descriptor) {
  if (fails(FSYNC)) return -1;
  if (changes()) end();
  note_sync(descriptor);
  return (int)syscall(SYS_fsync, descriptor);
}
int fdatasync(int descriptor) { return fsync(descriptor); }

/* A system that could not write in time says so at the end: the descriptor is gone all the same. */
int close(int descriptor) {
  const int bad = fails(CLOSE);
  const int out = (int)syscall(SYS_close, descriptor);
  if (!bad) return out;
  errno = error_number;
  return -1;
}

int unlink(const char *path) {
  if (fails(REMOVE)) return -1;
  if (changes()) end();
  return (int)syscall(SYS_unlinkat, AT_FDCWD, path, 0);
}

int mkdir(const char *path, mode_t mode) {
  if (fails(FOLDER)) return -1;
  if (changes()) end();
  return (int)syscall(SYS_mkdirat, AT_FDCWD, path, mode);
}

/* --- the standard output --- */

static int set_aside = -1;

/* Takes the standard output's file away before the n-th printing, and gives it back after it. */
static void print_begins(FILE *to) {
  if (to != stdout || !fails(PRINT) || set_aside >= 0) return;
  const int full = (int)syscall(SYS_openat, AT_FDCWD, "/dev/full", O_WRONLY | O_CLOEXEC);
  set_aside = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 400);
  dup2(full, STDOUT_FILENO);
  syscall(SYS_close, full);
}
static void print_ends(void) {
  if (set_aside < 0 || on) return;
  real_fflush(stdout); /* into the full one */
  dup2(set_aside, STDOUT_FILENO);
  syscall(SYS_close, set_aside);
  set_aside = -1;
}

size_t fwrite(const void *from, size_t size, size_t n, FILE *to) {
  print_begins(to);
  const size_t out = real_fwrite(from, size, n, to);
  print_ends();
  return out;
}
int fputs(const char *text, FILE *to) {
  print_begins(to);
  const int out = real_fputs(text, to);
  print_ends();
  return out;
}
int fflush(FILE *to) {
  print_begins(to);
  const int out = real_fflush(to);
  print_ends();
  return out;
}

/* --- threads --- */

int pthread_create(pthread_t *out, const pthread_attr_t *how, void *(*run)(void *), void *with) {
  return fails(THREAD) ? EAGAIN : real_pthread_create(out, how, run, with);
}

/* --- the beginning and the end --- */

static void leave_child_alone(void) { active = 0; }

__attribute__((constructor)) static void begin(void) {
  const char *const fault = getenv("HVI_FAULT"), *const file = getenv("HVI_FAULT_COUNTS"), *const undo = getenv("HVI_FAULT_UNDO");
  char what[32] = "", mode[32] = "";
  if (fault && sscanf(fault, "%31[a-z],%ld,%31[a-z0-9],%d", what, &wanted, mode, &error_number) < 2) abort();
  for (int k = 0; k < KINDS; ++k)
    if (strcmp(what, names[k]) == 0) kind = k;
  if (fault && kind < 0) abort();
  on = strcmp(mode, "on") == 0;
  half = strcmp(mode, "half") == 0;
  pretended = kind == LOSS ? atol(mode) : 0;
  if (file) snprintf(counts_file, sizeof counts_file, "%s", file);
  if (undo) snprintf(undo_folder, sizeof undo_folder, "%s", undo);
  for (const char *name = "LD_PRELOAD\0HVI_FAULT\0HVI_FAULT_COUNTS\0HVI_FAULT_UNDO\0"; *name; name += strlen(name) + 1) unsetenv(name);
  real_fopen = (__typeof__(real_fopen))next("fopen64");
  real_opendir = (__typeof__(real_opendir))next("opendir");
  real_fwrite = (__typeof__(real_fwrite))next("fwrite");
  real_fputs = (__typeof__(real_fputs))next("fputs");
  real_fflush = (__typeof__(real_fflush))next("fflush");
  real_pthread_create = (__typeof__(real_pthread_create))next("pthread_create");
  pthread_atfork(NULL, NULL, leave_child_alone);
  owner = getpid();
  active = fault != NULL || file != NULL;
}

__attribute__((destructor)) static void finish(void) {
  if (!active || getpid() != owner) return;
  active = 0;
  if (!counts_file[0]) return;
  const int out = (int)syscall(SYS_openat, AT_FDCWD, counts_file, O_WRONLY | O_CREAT | O_TRUNC, 0666);
  for (int k = 0; k < KINDS; ++k) dprintf(out, "%s %ld\n", names[k], atomic_load(&counts[k]));
  syscall(SYS_close, out);
}
