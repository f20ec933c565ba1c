#pragma once

#include <memory>
#include <vector>

#include "tumble/pyramid/pyramid.hpp"
#include "tumble/pyramid/store/mapped.hpp"

namespace tumble {

/// What the pyramid of a recording that is being made shows.
struct PyramidMoment {
  Recording header;
  std::vector<PyramidChannel> channels;
  std::vector<store::MappedChannel> mapped;
  std::vector<std::shared_ptr<const void>> owners;  ///< of the pages
};

}  // namespace tumble
