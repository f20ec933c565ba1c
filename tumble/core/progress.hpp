#pragma once

#include <functional>
#include <string_view>

namespace tumble {

/// How long work says how far it is: done from 0 to 1, and what it is doing. May be empty. Called from one thread.
using Progress = std::function<void(double done, std::string_view what)>;

/// Reports how far the work is, done [1] from 0 to 1, where somebody listens.
inline void report(const Progress& progress, double done, std::string_view what) {
  if (progress) progress(done, what);
}

}  // namespace tumble
