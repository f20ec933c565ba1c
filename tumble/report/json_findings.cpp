#include "tumble/report/json_findings.hpp"

#include <cmath>
#include <optional>

#include "tumble/report/legacy/legacy.hpp"
#include "tumble/report/limit_text.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

FindingValue value_of(const std::string& name, const Node& node) {
  if (node.is_text()) return {name, node.text()};
  if (node.is_whole()) return {name, node.integer()};
  if (!node.is_object()) return {name, node.number(NAN)};
  if (const Node phrase = node.optional("phrase"); !phrase.absent()) return {name, Phrase{phrase.text()}};
  const Unit unit = unit_of(node["unit"]);
  return {name, unit.to_si(node["value"].number(NAN)), unit};
}

Place place_of(const Node& node) {
  if (node.absent()) return {};
  const Node label = node.optional("label"), time = node.optional("time");
  return {label.absent() ? "" : label.text(), time.absent() ? NAN : time.number(NAN)};
}

std::optional<Bound> bound_of(const Node& node) {
  if (node.absent()) return std::nullopt;
  const Node text = node["unit"], value = node.optional("value");
  if (!node.is_object()) return std::nullopt;
  if (value.absent()) value.complain("a finite number is expected");
  const Unit unit = unit_of(text);
  return Bound{unit.to_si(value.number(NAN)), unit};
}

/// Whether two limits are the same, but for rounding of their decimals.
bool is_same(const Limit& a, const Limit& b) {
  constexpr double rounding = 1e-9;
  const auto same = [](double x, double y) { return x == y || std::abs(x - y) <= rounding * std::abs(y); };
  return same(a.lowest(), b.lowest()) && same(a.highest(), b.highest());
}

/// The limit of a verdict: lower and upper, and the text that says the same. A result of before has the text alone.
Limit limit_of(const Node& node) {
  const Limit limit{bound_of(node.optional("lower")), bound_of(node.optional("upper"))};
  const Node text = node["limit"];
  if (!text.is_text()) return text.text(), limit;
  try {
    const Limit written = legacy::limit_of(text.text());
    if (!limit.lower && !limit.upper) return written;
    if (!is_same(limit, written))
      text.complain(say("'{}' is not the limit that lower and upper say, '{}'", text.text(), limit_text(limit)));
  } catch (const Error& error) {
    text.complain(reason_of(error));
  }
  return limit;
}

}  // namespace

Finding finding_of(const Node& node) {
  Finding finding;
  finding.severity = static_cast<Finding::Severity>(node["severity"].one_of({"info", "warning", "error"}));
  finding.message = node["message"].text();
  finding.where = node["where"].text();
  if (const Node code = node.optional("code"); !code.absent()) finding.code = code.text();
  if (const Node count = node.optional("count"); !count.absent()) finding.occurrences.count = count.whole();
  finding.occurrences.first = place_of(node.optional("first"));
  finding.occurrences.worst = place_of(node.optional("worst"));
  if (const Node values = node.optional("values"); !values.absent())
    for (const auto& name : values.names()) finding.values.push_back(value_of(name, values[name.c_str()]));
  for (const auto& hidden : node.optional("hidden").elements())
    finding.hidden.push_back({hidden["name"].text(), hidden.optional("channel").text()});
  if (finding.hidden.empty()) finding.hidden = legacy::hidden_by(finding);
  return finding;
}

Finding finding_of(const Node& node, const std::vector<Parameter>& parameters) {
  Finding finding = finding_of(node);
  const Node about = node.optional("about");
  if (about.absent() && finding.severity == Finding::Severity::error)
    finding.about = legacy::about_of(finding, parameters);
  for (const Node& index : about.elements()) {
    finding.about.push_back(static_cast<std::size_t>(index.whole()));
    if (finding.about.back() >= parameters.size()) index.complain("the result has no such parameter");
  }
  return finding;
}

Verdict verdict_of(const Node& node) {
  return {node["parameter"].text(),
          static_cast<Verdict::Outcome>(node["outcome"].one_of({"pass", "fail", "undecided"})), limit_of(node)};
}

}  // namespace tumble
