#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <string_view>

#include "tumble/core/progress.hpp"
#include "tumble/math/interruption.hpp"

/// The parts of the module `_tumble`: values and calls of the library, without logic of their own. What users see is
/// the Python package beside it, which calls these.
namespace tumble::python {

namespace nb = nanobind;

void bind_errors(nb::module_& module);
void bind_units(nb::module_& module);
void bind_recordings(nb::module_& module);
void bind_plans(nb::module_& module);
void bind_results(nb::module_& module);
void bind_tasks(nb::module_& module);
void bind_stability(nb::module_& module);
void bind_figures(nb::module_& module);
void bind_archive(nb::module_& module);
void bind_fleet(nb::module_& module);
void bind_fleet_summary(nb::module_& module);
void bind_compat_allantools(nb::module_& module);
void bind_compat_imucal(nb::module_& module);

/// Lets the interpreter end while other threads are in a call. CPython up to 3.13 ends a thread that asks for its lock
/// then: it unwinds the stack, and C++ aborts a program where a destructor is unwound.
void prepare_for_the_end();
/// Called before this thread asks for the lock. Where the interpreter is ending, the thread waits for the end of the
/// process, as CPython does from 3.14 on; except the main thread, which goes on.
void wait_where_python_is_over();

/// Counts a call at work without the interpreter's lock. While there is one, the process ends without destructors: they
/// would take away what the threads of the call use.
struct Call {
  Call();
  ~Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
};

/// Looks for Ctrl+C, at most 20 times a second. Called without the interpreter's lock, which it takes.
class CtrlC {
 public:
  /// Whether it is time to look.
  bool is_due();
  void look();

 private:
  std::chrono::steady_clock::time_point last_{};
};

/// A call without the interpreter's lock, which Ctrl+C ends: nb::call_guard<Unlocked>.
class Unlocked {
  Call call_;
  CtrlC ctrl_c_;
  Interruption interruption_{[this] {
    if (ctrl_c_.is_due()) ctrl_c_.look();
  }};
  nb::gil_scoped_release released_;
  struct Wait {
    ~Wait() { wait_where_python_is_over(); }
  } wait_;
};

/// Progress of a long call, made without the interpreter's lock: 20 times a second it takes the lock, looks for Ctrl+C,
/// and calls a Python function (done from 0 to 1, what) unless that is None. It must outlive the call.
class Listener {
 public:
  explicit Listener(nb::object call) : call_(std::move(call)) {}

  Progress progress() {
    return [this](double done, std::string_view what) { hear(done, what); };
  }

 private:
  void hear(double done, std::string_view what);

  nb::object call_;
  CtrlC ctrl_c_;
};

}  // namespace tumble::python
