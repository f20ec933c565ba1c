#include <algorithm>
#include <cmath>

#include "tumble/exchange/certificate/page.hpp"
#include "tumble/exchange/certificate/work.hpp"
#include "tumble/exchange/certificate/xml.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/report/limit_text.hpp"

namespace tumble::certificate {
namespace {

/// "tumble_gyro_x_bias": our kind of quantity, letters, digits and "_".
std::string kind_of(const std::string& parameter) {
  std::string kind = "basic_measuredValue tumble_";
  for (const char c : parameter)
    kind += (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ? c : '_';
  return kind;
}

/// The word of the DCC; null where no statement could be made.
const char* conformity_word(Decision::Outcome outcome) {
  constexpr const char* words[] = {"pass", "conditionalPass", "conditionalFail", "fail", nullptr};
  return words[static_cast<std::size_t>(outcome)];
}

void write_limits(Xml data, const Tolerance& tolerance, const std::string& kind, const Unit& unit) {
  for (const auto& [value, end] : {std::pair{tolerance.lower, "Lower"}, std::pair{tolerance.upper, "Upper"}}) {
    if (!std::isfinite(value)) continue;
    const auto quantity = element(data, "dcc:quantity");
    mark(quantity, "refType", (kind + end));
    quantity_value(quantity, value, unit, nullptr);
  }
}

void write_statement(Xml list, const Statement& statement, const Unit& unit, const Certificate& certificate) {
  const auto& details = certificate.details;
  const auto meta = element(list, "dcc:metaData");
  mark(meta, "refType", "basic_conformity");
  leaf(meta, "dcc:norm", "ILAC-G8:09/2019");
  const auto declaration = element(meta, "dcc:declaration");
  for (const auto language : languages_of(details)) {
    const std::string of = text_of(language, "certificate", "probability");
    leaf(declaration, "dcc:content",
         limit_text(statement.limit) + ": " + outcome_in_words(statement.outcome, language) +
             (statement.decision ? "; " + of + " " + percent(statement.decision->conformance) + " %" : ""));
    mark(declaration.last_child(), "lang", code_of(language));
  }
  if (const char* word = conformity_word(statement.outcome)) leaf(meta, "dcc:conformity", word);
  const auto data = element(meta, "dcc:data");
  write_limits(data, statement.tolerance, "basic_toleranceLimit", unit);
  if (statement.decision && !statement.decision->acceptance.empty())
    write_limits(data, statement.decision->acceptance, "basic_acceptanceLimit", unit);
}

void write_meta(Xml quantity, const std::string& parameter, const Unit& unit, const Certificate& certificate) {
  Xml list;
  for (const auto& statement : certificate.statements) {
    if (statement.parameter != parameter) continue;
    if (!list) list = element(quantity, "dcc:measurementMetaData");
    write_statement(list, statement, unit, certificate);
  }
}

void write_quantity(Xml data, std::size_t index, const Certificate& certificate) {
  const Parameter& parameter = certificate.estimate.parameters[index];
  const Measured measured = measured_of(certificate.estimate, index);
  const auto quantity = element(data, "dcc:quantity");
  mark(quantity, "refType", kind_of(parameter.name));
  plain(quantity, "dcc:name", parameter.name);
  if (!parameter.description.empty()) english(quantity, "dcc:description", parameter.description, certificate.details);
  quantity_value(quantity, parameter.value, parameter.unit, &measured);
  write_meta(quantity, parameter.name, parameter.unit, certificate);
}

/// A parameter that the data show only an upper limit of, or none.
void write_hidden(Xml data, const Statement& statement, const Certificate& certificate) {
  const auto& details = certificate.details;
  const auto quantity = element(data, "dcc:quantity");
  mark(quantity, "refType", kind_of(statement.parameter));
  plain(quantity, "dcc:name", statement.parameter);
  Unit unit;
  if (const auto upper = find_upper_limit(certificate.estimate, statement.parameter)) {
    unit = upper->unit;
    said(quantity, "dcc:noQuantity", details, "below", decimal(unit.from_si(upper->value)), unit.text());
  } else {
    said(quantity, "dcc:noQuantity", details, "not_determined", statement.parameter);
  }
  write_meta(quantity, statement.parameter, unit, certificate);
}

/// Words in one list; one word stands for all where they are equal.
std::string list_of_units(const std::vector<std::string>& units) {
  if (std::ranges::all_of(units, [&](const auto& unit) { return unit == units.front(); })) return units.front();
  std::string text;
  for (const auto& unit : units) text += (text.empty() ? "" : " ") + unit;
  return text;
}

Dimension product(const Dimension& a, const Dimension& b) {
  Dimension sum = a;
  for (std::size_t i = 0; i < sum.halves.size(); ++i)
    sum.halves[i] = static_cast<signed char>(a.halves[i] + b.halves[i]);
  return sum;
}

void write_covariance(Xml list, const Estimate& estimate, const std::vector<std::size_t>& indices) {
  const auto region =
      element(element(list, "si:measurementUncertaintyMultivariateXMLList"), "si:ellipsoidalRegionMUXMLList");
  const auto matrix = element(region, "si:covarianceMatrixXMLList");
  for (const std::size_t j : indices) {
    std::string values;
    std::vector<std::string> units;
    for (const std::size_t i : indices) {
      const double covariance = i < j ? estimate.covariance(i, j) : estimate.covariance(j, i);
      values += (values.empty() ? "" : " ") + decimal(covariance);
      units.push_back(
          dsi_unit(product(estimate.parameters[i].unit.dimension(), estimate.parameters[j].unit.dimension())));
    }
    const auto column = element(element(matrix, "si:columnXMLList"), "si:covarianceXMLList");
    leaf(column, "si:valueXMLList", values);
    leaf(column, "si:unitXMLList", list_of_units(units));
  }
  leaf(region, "si:coverageFactorXMLList",
       decimal(std::sqrt(chi_square_quantile(0.95, static_cast<double>(indices.size())))));
  leaf(region, "si:coverageProbabilityXMLList", "0.95");
  leaf(region, "si:distributionXMLList", "normal");
}

/// A word for a list, in which a blank would begin the next one: channels of recordings have names like "Gyro X".
std::string label_of(const std::string& parameter) {
  std::string label = printable_text(parameter);
  std::ranges::replace(label, ' ', '_');
  return label.empty() ? "_" : label;
}

void write_all_parameters(Xml data, const Certificate& certificate, const std::vector<std::size_t>& indices) {
  const auto& estimate = certificate.estimate;
  const auto quantity = element(data, "dcc:quantity");
  mark(quantity, "refType", "basic_measuredValue tumble_allParameters");
  said(quantity, "dcc:name", certificate.details, "all_parameters");
  const auto list = element(quantity, "si:realListXMLList");
  std::string labels, values, sds;
  std::vector<std::string> units;
  for (const std::size_t i : indices) {
    const auto blank = labels.empty() ? "" : " ";
    labels += blank + label_of(estimate.parameters[i].name);
    values += blank + decimal(estimate.parameters[i].value);
    sds += blank + decimal(standard_uncertainty(estimate, i));
    units.push_back(dsi_unit(estimate.parameters[i].unit.dimension()));
  }
  leaf(list, "si:labelXMLList", labels);
  leaf(list, "si:valueXMLList", values);
  leaf(list, "si:unitXMLList", list_of_units(units));
  leaf(element(element(list, "si:measurementUncertaintyUnivariateXMLList"), "si:standardMUXMLList"),
       "si:valueStandardMUXMLList", sds);
  write_covariance(list, estimate, indices);
}

}  // namespace

void write_results(Xml measurement, const Certificate& certificate) {
  const auto result = element(element(measurement, "dcc:results"), "dcc:result");
  said(result, "dcc:name", certificate.details, "results");
  const auto data = element(result, "dcc:data");
  const auto indices = determined(certificate.estimate);
  for (const std::size_t index : indices) write_quantity(data, index, certificate);
  std::vector<std::string> hidden;
  for (const auto& statement : certificate.statements) {
    const bool shown = statement.index && std::isfinite(certificate.estimate.parameters[*statement.index].value);
    if (shown || std::ranges::find(hidden, statement.parameter) != hidden.end()) continue;
    hidden.push_back(statement.parameter);
    write_hidden(data, statement, certificate);
  }
  if (indices.size() > 1) write_all_parameters(data, certificate, indices);
}

}  // namespace tumble::certificate
