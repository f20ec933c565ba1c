#include "tumble/tasks/prior.hpp"

#include <fmt/format.h>

#include "tumble/archive/populations.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/reduce/with_prior.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/provenance.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

std::string where(const Plan& plan) { return plan.file.empty() ? "--set prior" : plan.file; }

/// The population itself, or the one that a result was made with.
Estimate of_file(const Plan& plan, std::string& sha256) {
  const auto text = read_text_file(plan.prior.from);
  sha256 = sha256_of(text);
  auto estimate = estimate_from_json(text, plan.prior.from);
  return !estimate.population && estimate.prior ? *estimate.prior->population : estimate;
}

Estimate of_archive(const Plan& plan, const Archive* archive) {
  if (!archive)
    throw Error(Error::Kind::bad_input,
                say("{}: prior = \"archive\" needs the archive: --archive ARCHIVE or the environment variable "
                    "TUMBLE_ARCHIVE; or name a file that `tumble population` wrote",
                    Name{where(plan)}));
  return population_of(*archive, {plan.instrument_model, plan.method, plan.instrument_serial});
}

}  // namespace

void read_prior(Plan& plan, const Archive* archive) {
  auto& prior = plan.prior;
  if (prior.from.empty() || prior.population) return;
  auto population = prior.from == "archive" ? of_archive(plan, archive) : of_file(plan, prior.sha256);
  auto problems = problems_of_prior(population, plan.instrument_model, plan.method);
  for (auto& problem : problems) problem = say("{}: the prior {} {}", Name{where(plan)}, Name{prior.from}, problem);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  prior.population = std::make_shared<const Estimate>(std::move(population));
}

void add_prior(const Plan& plan, Estimate& estimate, bool certain) {
  const auto& prior = plan.prior;
  if (prior.from.empty()) return;
  if (!prior.population) throw Error(Error::Kind::internal, "the prior of the plan was not read");
  auto use = with_population(estimate, *prior.population, certain);
  use.from = prior.from == "archive" ? prior.from : relative_to(plan, prior.from);
  estimate.provenance.settings["prior"] = use.from;
  use.verdicts = prior.verdicts;
  estimate.provenance.settings["prior.sha256"] = prior.population->population->sha256;
  for (auto& finding : about_prior(estimate, use)) estimate.findings.push_back(std::move(finding));
  estimate.tables.push_back(prior_table(estimate, use));
  estimate.prior = std::make_shared<const PriorUse>(std::move(use));
}

}  // namespace tumble
