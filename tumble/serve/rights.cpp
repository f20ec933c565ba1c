#include "tumble/serve/rights.hpp"

namespace tumble {

std::string name(Right right) {
  switch (right) {
    case Right::read:
      return "read";
    case Right::operate:
      return "operate";
    case Right::approve:
      break;
  }
  return "approve";
}

const std::vector<Right>& all_rights() {
  static const std::vector<Right> all{Right::read, Right::operate, Right::approve};
  return all;
}

}  // namespace tumble
