#include "tumble/methods/dtg_centrifuge/compensate.hpp"

namespace tumble::dtg {

Compensation compensate(const Estimate& estimate, const Recording& recording) {
  (void)estimate;
  return {recording, {}, {}};
}

}  // namespace tumble::dtg
