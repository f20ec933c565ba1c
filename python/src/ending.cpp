#include <dlfcn.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "bindings.hpp"

namespace tumble::python {
namespace {

std::terminate_handler others = nullptr;
int (*is_ending)() = nullptr;  ///< Py_IsFinalizing, which the stable ABI does not have
std::atomic<int> calls{0};     ///< at work without the interpreter's lock, or waiting for the end

bool is_over_for_this_thread() {
  if (is_ending == nullptr || syscall(SYS_gettid) == getpid()) return false;  // the main thread goes on
  return is_ending() != 0 || Py_IsInitialized() == 0;
}

/// A thread that asked for the lock just before the end.
[[noreturn]] void wait_or_terminate() {
  if (!std::current_exception()) wait_where_python_is_over();
  others();
  std::abort();
}

/// Catalogues, texts and tables of the library, and what others keep, would be destroyed while threads use them. Python
/// has ended by then, and its handlers have run.
void end_without_destructors(int status, void*) {
  if (calls == 0) return;
  std::fflush(nullptr);
  _exit(status);
}

/// As late as can be: what is destroyed at the end is destroyed in reverse order of its making.
void look_at_the_end() {
#ifdef __GLIBC__
  on_exit(end_without_destructors, nullptr);
#endif
}

}  // namespace

Call::Call() { ++calls; }
Call::~Call() { --calls; }

void wait_where_python_is_over() {
  while (is_over_for_this_thread()) pause();
}

void prepare_for_the_end() {
  for (const char* const name : {"Py_IsFinalizing", "_Py_IsFinalizing"})
    if (is_ending == nullptr) is_ending = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, name));
  if (is_ending != nullptr) others = std::set_terminate(wait_or_terminate);
  Py_AtExit(look_at_the_end);
}

}  // namespace tumble::python
