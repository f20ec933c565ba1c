#include "tumble/formats/testing/reference_texts.hpp"

namespace tumble {

std::string reference_text(const std::string& name) {
  return std::string(TUMBLE_SOURCE_DIR) + "/tests/reference/texts/" + name;
}

}  // namespace tumble
