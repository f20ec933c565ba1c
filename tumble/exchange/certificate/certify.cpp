#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/certificate.hpp"
#include "tumble/exchange/certificate/work.hpp"
#include "tumble/report/limit_text.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace certificate {

Measured measured_of(const Estimate& estimate, std::size_t index) {
  const Parameter& parameter = estimate.parameters[index];
  return {parameter.value, standard_uncertainty(estimate, index), parameter.degrees_of_freedom, parameter.lower,
          parameter.upper};
}

std::vector<std::size_t> determined(const Estimate& estimate) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i)
    if (std::isfinite(estimate.parameters[i].value)) indices.push_back(i);
  return indices;
}

}  // namespace certificate

namespace {

using certificate::measured_of;

/// [SI] The limit that a verdict was judged by; `unit` of the parameter, null where the result does not have it.
Tolerance tolerance_of(const Limit& limit, const Unit* unit) {
  for (const auto* bound : {&limit.lower, &limit.upper})
    if (*bound && unit != nullptr && (*bound)->unit.dimension() != unit->dimension())
      throw Error(Error::Kind::bad_input,
                  say("the limit {} is in {} [{}], the parameter in {} [{}]", Name{bound_text(**bound)},
                      Name{(*bound)->unit.text()}, Name{name((*bound)->unit.dimension())}, Name{unit->text()},
                      Name{name(unit->dimension())}));
  const Tolerance limits{limit.lowest(), limit.highest()};
  if (limits.empty())
    throw Error(Error::Kind::bad_input, say("the limit '{}' has its lower end above its upper end", limit_text(limit)));
  return limits;
}

/// A parameter that the data do not show is judged from its upper limit, as in the result.
Decision::Outcome outcome_of_hidden(Verdict::Outcome outcome) {
  if (outcome == Verdict::Outcome::undecided) return Decision::Outcome::undecided;
  return outcome == Verdict::Outcome::pass ? Decision::Outcome::pass : Decision::Outcome::fail;
}

Statement statement_on(const Verdict& verdict, const Estimate& estimate, const CertificateDetails& details,
                       const std::vector<std::string>& undermined) {
  Statement statement{.parameter = verdict.parameter, .limit = verdict.limit};
  statement.undermined = std::ranges::find(undermined, verdict.parameter) != undermined.end();
  const auto* parameter = find_parameter(estimate, verdict.parameter);
  statement.tolerance = tolerance_of(verdict.limit, parameter ? &parameter->unit : nullptr);
  if (!parameter) {
    statement.outcome = outcome_of_hidden(verdict.outcome);
    return statement;
  }
  statement.index = static_cast<std::size_t>(parameter - estimate.parameters.data());
  if (statement.undermined || !std::isfinite(parameter->value)) return statement;
  const Measured measured = measured_of(estimate, *statement.index);
  statement.decision = decide(measured, statement.tolerance, *details.rule);
  statement.outcome = statement.decision->outcome;
  for (const auto& known : details.populations)
    if (known.parameter == verdict.parameter)
      statement.global_risk =
          global_risk(known.population, measured.sd, statement.tolerance, statement.decision->acceptance);
  return statement;
}

/// Of all statements with a decision; absent with fewer than two.
std::optional<double> joint_of(const Certificate& certificate) {
  std::vector<Measured> measured;
  std::vector<Tolerance> tolerances;
  std::vector<std::size_t> indices;
  for (const auto& statement : certificate.statements)
    if (statement.decision) {
      indices.push_back(*statement.index);
      measured.push_back(measured_of(certificate.estimate, indices.back()));
      tolerances.push_back(statement.tolerance);
    }
  if (indices.size() < 2) return std::nullopt;
  const Matrix& covariance = certificate.estimate.covariance;
  Matrix correlation(indices.size(), indices.size(), 1.0);
  for (std::size_t i = 0; i < indices.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      correlation(i, j) = correlation(j, i) =
          indices[i] == indices[j] ? 1.0
                                   : covariance(indices[i], indices[j]) / std::sqrt(covariance(indices[i], indices[i]) *
                                                                                    covariance(indices[j], indices[j]));
  return joint_conformance(measured, tolerances, correlation);
}

/// An interval of its own is about the value, and wider than nothing.
bool has_wrong_interval(const Parameter& parameter) {
  if (!std::isfinite(parameter.lower) || !std::isfinite(parameter.upper)) return false;
  const bool about = parameter.lower <= parameter.value && parameter.value <= parameter.upper;
  return !about || !(parameter.lower < parameter.upper);
}

/// Pairs of parameters that have a value, but no covariance: it would be taken for one in the document and for all
/// parameters together.
void find_missing_covariances(const Estimate& estimate, Problems& problems) {
  const auto indices = certificate::determined(estimate);
  for (const std::size_t i : indices)
    for (const std::size_t j : indices)
      if (j < i && !std::isfinite(estimate.covariance(i, j) + estimate.covariance(j, i)))
        problems.push_back(say("the covariance of {} and {} is missing: a certificate cannot state it",
                               Name{estimate.parameters[j].name}, Name{estimate.parameters[i].name}));
}

/// A certificate states what was measured, and how well.
void refuse_unmeasured(const Estimate& estimate) {
  Problems problems;
  if (estimate.provenance.inputs.empty())
    problems.emplace_back("the result is a prediction or names no recording: a certificate needs measured data");
  if (certificate::determined(estimate).empty()) problems.emplace_back("the result has no parameter with a value");
  constexpr double least_degrees = 0.01;  // of Student's t with fewer no factor is left
  for (const std::size_t i : certificate::determined(estimate)) {
    const Parameter& parameter = estimate.parameters[i];
    if (const double sd = standard_uncertainty(estimate, i);
        !(sd > 0.0 && std::isfinite(sd) && parameter.degrees_of_freedom >= least_degrees))
      problems.push_back(say("{} has no uncertainty: a certificate cannot state it", Name{parameter.name}));
    else if (has_wrong_interval(parameter))
      problems.push_back(
          say("{} has a 95 % interval that does not hold its value, or of no width: a "
              "certificate cannot state it",
              Name{parameter.name}));
  }
  if (problems.empty()) find_missing_covariances(estimate, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

void refuse_details(const Estimate& estimate, const CertificateDetails& details) {
  auto problems = missing_details(details, estimate);
  for (auto& wrong : wrong_details(details)) problems.push_back(std::move(wrong));
  std::vector<std::string> names;
  for (const auto& parameter : estimate.parameters) names.push_back(parameter.name);
  for (const auto& known : details.populations) {
    const auto* parameter = find_parameter(estimate, known.parameter);
    if (!parameter)
      problems.push_back(say("{}: [[population]] parameter: the result has no '{}' (parameters: {})",
                             Name{details.file}, known.parameter, fmt::join(names, ", ")));
    else if (parameter->unit.dimension() != known.unit.dimension())
      problems.push_back(say("{}: [[population]] '{}': {} [{}] is given, {} [{}] is expected", Name{details.file},
                             known.parameter, Name{known.unit.text()}, Name{name(known.unit.dimension())},
                             Name{parameter->unit.text()}, Name{name(parameter->unit.dimension())}));
  }
  if (const auto& stated = details.item.serial;
      !stated.empty() && !estimate.instrument_serial.empty() && stated != estimate.instrument_serial)
    problems.push_back(say("the result is of unit {}: the certificate cannot be of {}",
                           Name{estimate.instrument_serial}, Name{stated}));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

}  // namespace

Certificate certify(const Estimate& estimate, const CertificateDetails& stated,
                    const std::vector<std::string>& undermined) {
  refuse_unmeasured(estimate);
  const CertificateDetails details = certificate::with_days_of_test(stated, estimate);
  refuse_details(estimate, details);
  Certificate certificate{.estimate = estimate, .details = details};
  CertifiedItem& item = certificate.details.item;
  if (item.model.empty()) item.model = estimate.instrument_model;
  if (item.serial.empty()) item.serial = estimate.instrument_serial;
  certificate.notes = certificate::doubts_about_days(stated, estimate);
  Problems problems;
  if (details.rule)
    for (const auto& verdict : estimate.verdicts) try {
        certificate.statements.push_back(statement_on(verdict, estimate, details, undermined));
      } catch (const Error& error) {
        for (const auto& problem : error.problems)
          problems.push_back(within(say("{}", Name{verdict.parameter}), problem));
      }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  certificate.joint = joint_of(certificate);
  return certificate;
}

}  // namespace tumble
