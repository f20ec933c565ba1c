// Preloaded into a program (tests/disk_faults_test.py): the n-th call that changes a disk fails, and with
// TUMBLE_FAULT_ON all after it. Calls are counted whatever their kind, descriptors of the terminal excepted. The file
// TUMBLE_FAULT_SEEN says that the call was reached.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/uio.h>
#include <unistd.h>

static int fails(void) {
  static atomic_int calls;
  const char* const nth = getenv("TUMBLE_FAULT");
  if (nth == NULL) return 0;
  const int now = ++calls, wanted = atoi(nth);
  if (now < wanted || (now > wanted && getenv("TUMBLE_FAULT_ON") == NULL)) return 0;
  const char* const seen = getenv("TUMBLE_FAULT_SEEN");
  const int descriptor = seen == NULL ? -1 : open(seen, O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  (void)descriptor;  // it stays open: close() is one of these calls
  errno = EIO;
  return 1;
}

static int of_terminal(int descriptor) { return descriptor <= 2; }

#define next(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int descriptor, const void* bytes, size_t count) {
  return !of_terminal(descriptor) && fails() ? -1 : next(write)(descriptor, bytes, count);
}
ssize_t writev(int descriptor, const struct iovec* parts, int count) {
  return !of_terminal(descriptor) && fails() ? -1 : next(writev)(descriptor, parts, count);
}
ssize_t pwrite(int descriptor, const void* bytes, size_t count, off_t place) {
  return fails() ? -1 : next(pwrite)(descriptor, bytes, count, place);
}
ssize_t pwrite64(int descriptor, const void* bytes, size_t count, off64_t place) {
  return fails() ? -1 : next(pwrite64)(descriptor, bytes, count, place);
}
int ftruncate(int descriptor, off_t size) { return fails() ? -1 : next(ftruncate)(descriptor, size); }
int ftruncate64(int descriptor, off64_t size) { return fails() ? -1 : next(ftruncate64)(descriptor, size); }
int fsync(int descriptor) { return fails() ? -1 : next(fsync)(descriptor); }
int fdatasync(int descriptor) { return fails() ? -1 : next(fdatasync)(descriptor); }
int rename(const char* from, const char* to) { return fails() ? -1 : next(rename)(from, to); }
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
  return fails() ? -1 : next(renameat2)(from_folder, from, to_folder, to, flags);
}
int link(const char* from, const char* to) { return fails() ? -1 : next(link)(from, to); }
int unlink(const char* path) { return fails() ? -1 : next(unlink)(path); }

/// The descriptor is free afterwards, as on Linux.
int close(int descriptor) {
  const int failed = !of_terminal(descriptor) && fails();
  const int closed = next(close)(descriptor);
  if (!failed) return closed;
  errno = EIO;
  return -1;
}
