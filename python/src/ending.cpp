#include <dlfcn.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <exception>

#include "bindings.hpp"

namespace tumble::python {
namespace {

std::terminate_handler others = nullptr;
int (*is_ending)() = nullptr;  ///< Py_IsFinalizing, which the stable ABI does not have

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

}  // namespace

void wait_where_python_is_over() {
  while (is_over_for_this_thread()) pause();
}

void prepare_for_the_end() {
  for (const char* const name : {"Py_IsFinalizing", "_Py_IsFinalizing"})
    if (is_ending == nullptr) is_ending = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, name));
  if (is_ending != nullptr) others = std::set_terminate(wait_or_terminate);
}

}  // namespace tumble::python
