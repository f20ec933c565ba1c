#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <exception>
#include <filesystem>
#include <new>

#include "bindings.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/units/error.hpp"

namespace tumble::python {
namespace {

void raise(std::string_view kind, const Problems& problems) {
  nb::list texts;  // a message may quote bytes that are no UTF-8
  for (const std::string& one : texts_of(problems))
    texts.append(nb::steal(PyUnicode_DecodeUTF8(one.data(), static_cast<Py_ssize_t>(one.size()), "replace")));
  const std::string json = problems_to_json(kind, problems, Language::english);
  const nb::object made = nb::module_::import_("tumble._errors").attr("error_of")(std::string(kind), texts, json);
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(made.ptr())), made.ptr());
}

/// The package says which exception an error is.
void translate(const std::exception_ptr& failure, void*) {
  try {
    std::rethrow_exception(failure);
  } catch (const Error& error) {
    raise(code_of(error.kind), error.problems);
  } catch (const std::bad_alloc&) {
    throw;  // MemoryError
  } catch (const std::filesystem::filesystem_error& error) {
    raise("bad_file", {Problem(error.what())});
  } catch (const std::exception& error) {
    raise("internal", {Problem(error.what())});
  }
}

}  // namespace

bool CtrlC::is_due() {
  using namespace std::chrono_literals;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < 50ms) return false;
  last_ = now;
  return true;
}

void CtrlC::look() {
  wait_where_python_is_over();
  const nb::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

void Listener::hear(double done, std::string_view what) {
  if (!ctrl_c_.is_due() && done < 1.0) return;
  ctrl_c_.look();
  wait_where_python_is_over();
  const nb::gil_scoped_acquire lock;
  if (!call_.is_none()) call_(done, nb::str(what.data(), what.size()));
}

void bind_errors(nb::module_&) { nb::register_exception_translator(translate); }

}  // namespace tumble::python
