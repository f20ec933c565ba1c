#include "prior_option.hpp"

#include "tumble/tasks/prior.hpp"

namespace tumble::cli {

void read_prior_from(const ArchiveOptions& options, Plan& plan) {
  if (plan.prior.from != "archive") return;
  if (archive_address(options).empty()) {
    read_prior(plan);  // says what is missing
    return;
  }
  const Archive archive = open_archive(options);
  read_prior(plan, &archive);
}

}  // namespace tumble::cli
