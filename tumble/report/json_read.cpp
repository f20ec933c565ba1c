#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <unordered_set>

#include "tumble/core/budget.hpp"
#include "tumble/report/error_model/json.hpp"
#include "tumble/report/json_findings.hpp"
#include "tumble/report/json_node.hpp"
#include "tumble/report/legacy/legacy.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/result_members.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

void expect_size(const Node& node, std::size_t size, std::size_t expected, const std::string& why) {
  if (!node.absent() && size != expected) {
    node.complain(say("{} values are expected ({}), not {}", expected, Sentence(why.c_str()), size));
  }
}

Parameter parameter_of(const Node& node) {
  Parameter parameter;
  parameter.name = node["name"].text();
  parameter.symbol = node["symbol"].text();
  parameter.unit = unit_of(node["unit"]);
  parameter.value = parameter.unit.to_si(node["value"].number(NAN));
  parameter.description = node["description"].text();
  parameter.degrees_of_freedom = node.optional("degrees_of_freedom").number(infinity);
  if (const auto own = node.optional("own_interval"); own.flag()) {
    const auto ends = node["interval95"].numbers();
    expect_size(node["interval95"], ends.size(), 2, "the lower and the upper end");
    if (ends.size() == 2)
      parameter.lower = parameter.unit.to_si(ends[0]), parameter.upper = parameter.unit.to_si(ends[1]);
  }
  for (const Node& term : node.optional("contains").elements()) {
    const Unit unit = unit_of(term["unit"]);
    parameter.contains.push_back(
        {term["term"].text(), unit, term["weight"].number(NAN) * parameter.unit.factor() / unit.factor()});
  }
  return parameter;
}

/// Rows in displayed units; empty when the size is wrong.
Matrix matrix_of(const Node& node, std::size_t count) {
  const auto rows = node.elements();
  expect_size(node, rows.size(), count, "one row for each parameter");
  bool fits = rows.size() == count;
  Matrix matrix(count, count);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto row = rows[i].numbers();
    expect_size(rows[i], row.size(), count, "one for each parameter");
    fits = fits && row.size() == count;
    for (std::size_t j = 0; fits && j < count; ++j) matrix(i, j) = row[j];
  }
  return fits ? matrix : Matrix{};
}

/// The sd of a parameter is the root of the covariance's diagonal: a file where one was edited without the other would
/// say two things. 1e-6 lets numbers through that were written with seven digits.
void check_sd(const std::vector<Node>& parameters, const Matrix& covariance) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto node = parameters[i]["sd"];
    const double sd = node.number(NAN), variance = covariance.empty() ? NAN : covariance(i, i);
    if (variance < 0.0) node.complain(say("covariance[{0}][{0}] is negative", i));
    if (variance >= 0.0 && std::abs(sd - std::sqrt(variance)) > 1e-6 * std::sqrt(variance)) {
      node.complain(say("is {}, but covariance[{}][{}] gives {}", sd, i, i, std::sqrt(variance)));
    }
  }
}

/// A covariance is symmetric, and no correlation is beyond 1; to seven digits.
void check_pairs(const Node& node, const Matrix& covariance) {
  for (std::size_t i = 0; i < covariance.rows; ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double one = covariance(i, j), other = covariance(j, i);
      const double most = std::sqrt(covariance(i, i)) * std::sqrt(covariance(j, j));
      if (std::abs(one - other) > 1e-6 * most)
        return node.complain(say("is not symmetric: [{0}][{1}] is {2}, but [{1}][{0}] is {3}", i, j, one, other));
      if (std::abs(one) > (1.0 + 1e-6) * most)
        return node.complain(say("[{}][{}] is {}, beyond the {} that a correlation of 1 gives", i, j, one, most));
    }
}

/// A name stands once: what follows asks for parameters by name.
void check_names(const std::vector<Node>& nodes, const std::vector<Parameter>& parameters) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (!names.insert(parameters[i].name).second)
      nodes[i]["name"].complain(say("another parameter is called '{}'", parameters[i].name));
}

void covariance_to_si(Matrix& covariance, const std::vector<Parameter>& parameters) {
  for (std::size_t i = 0; i < covariance.rows; ++i) {
    for (std::size_t j = 0; j < covariance.columns; ++j) {
      covariance(i, j) *= parameters[i].unit.factor() * parameters[j].unit.factor();
    }
  }
}

/// [SI] p x q. Complains where a row is missing or has another length than the first.
Matrix factor_of(const Node& node, const std::vector<Parameter>& parameters) {
  const auto rows = node.elements();
  expect_size(node, rows.size(), parameters.size(), "one row a parameter");
  Matrix factor(parameters.size(), rows.empty() ? 0 : rows.front().numbers().size());
  for (std::size_t i = 0; i < std::min(rows.size(), parameters.size()); ++i) {
    const auto row = rows[i].numbers();
    expect_size(rows[i], row.size(), factor.columns, "as many as in the first row");
    for (std::size_t k = 0; k < std::min(row.size(), factor.columns); ++k)
      factor(i, k) = parameters[i].unit.difference_to_si(row[k]);
  }
  return factor;
}

/// A result of before the factors says standard uncertainties alone: one error a parameter then.
Contribution contribution_of(const Node& node, const std::vector<Parameter>& parameters) {
  auto variance = node["sd"].numbers();
  expect_size(node["sd"], variance.size(), parameters.size(), "one for each parameter");
  variance.resize(parameters.size(), NAN);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double sd = parameters[i].unit.difference_to_si(variance[i]);
    variance[i] = sd * sd;
  }
  const auto factor = node.optional("factor"), key = node.optional("key");
  Contribution line = independent_errors(node["source"].text(), variance);
  if (!key.absent()) line.key = key.text();
  if (!factor.absent()) line.factor = factor_of(factor, parameters);
  return line;
}

/// 1e-6 lets numbers through that were written with seven digits.
void check_factors(const Node& node, const Estimate& estimate) {
  const auto& c = estimate.covariance;
  if (c.rows != estimate.parameters.size() || c.rows == 0) return;  // complained of elsewhere
  const Matrix sum = covariance_of(estimate.budget, c.rows);
  for (std::size_t i = 0; i < c.rows; ++i)
    for (std::size_t j = 0; j <= i; ++j)
      if (std::abs(sum(i, j) - c(i, j)) > 1e-6 * std::sqrt(c(i, i)) * std::sqrt(c(j, j))) {
        node.complain(say("factors give the covariance {0} of {2} and {3}, not {1}", sum(i, j), c(i, j),
                          Name{estimate.parameters[i].name}, Name{estimate.parameters[j].name}));
        return;
      }
}

/// Budget of a result. Where it has no factors, what two results share can only be guessed from the sources' names.
void read_budget(const Node& node, Estimate& estimate) {
  bool signed_lines = true;
  for (const auto& line : node.elements()) {
    estimate.budget.push_back(contribution_of(line, estimate.parameters));
    signed_lines = signed_lines && !line.optional("factor").absent();
  }
  if (signed_lines) {
    check_factors(node, estimate);
    return;
  }
  estimate.findings.push_back({Finding::Severity::info, "budget_without_factors", {}});
}

Table table_of(const Node& node) {
  Table table;
  table.name = node["name"].text();
  table.caption = node.optional("caption").text();
  const Node for_programs = node.optional("for_programs");
  table.for_programs = !for_programs.absent() && for_programs.flag();
  for (const auto& column : node["columns"].elements()) {
    table.columns.push_back({column["name"].text(), unit_of(column["unit"])});
  }
  for (const auto& row : node["rows"].elements()) {
    const auto cells = row.elements();
    expect_size(row, cells.size(), table.columns.size(), "one for each column");
    auto& target = table.rows.emplace_back();
    for (std::size_t i = 0; i < std::min(cells.size(), table.columns.size()); ++i) {
      if (cells[i].is_text()) {
        target.emplace_back(cells[i].text());
      } else {
        target.emplace_back(table.columns[i].unit.to_si(cells[i].number(NAN)));
      }
    }
  }
  return table;
}

template <HasMembers<MembersFromJson> T>
T members_of(const Node& node) {
  T value;
  MembersFromJson visit(node);
  members(visit, value);
  return value;
}

Provenance provenance_of(const Node& node) {
  Provenance provenance;
  for (const auto& input : node["inputs"].elements()) {
    provenance.inputs.push_back({input["file"].text(), input["sha256"].text()});
  }
  for (const auto& plan : node.optional("plans").elements()) {
    const auto text = plan.optional("text");
    provenance.plans.push_back({plan["file"].text(), plan["sha256"].text(),
                                text.absent() ? std::nullopt : std::optional<std::string>(text.text())});
  }
  for (auto& [key, text] : node["settings"].members()) provenance.settings[key] = text;
  for (auto& [key, text] : node.optional("command_line").members()) provenance.command_line[key] = text;
  const auto seed = node.optional("seed");
  if (!seed.absent()) provenance.seed = seed.whole();
  if (const auto memory = node.optional("memory"); !memory.absent()) provenance.memory = memory.whole();
  return provenance;
}

/// Parameters, covariance and budget.
void read_numbers(const Node& top, Estimate& estimate) {
  const auto parameters = top["parameters"].elements();
  for (const auto& node : parameters) estimate.parameters.push_back(parameter_of(node));
  check_names(parameters, estimate.parameters);
  estimate.covariance = matrix_of(top["covariance"], parameters.size());
  check_sd(parameters, estimate.covariance);
  check_pairs(top["covariance"], estimate.covariance);
  covariance_to_si(estimate.covariance, estimate.parameters);
  read_budget(top["budget"], estimate);
}

PriorUse prior_of(const Node& node, const Node& with_prior) {
  PriorUse use;
  use.from = node["from"].text();
  use.verdicts = node["verdicts"].flag();
  use.belongs = node["belongs"].number(1.0);
  use.belongs_by_one = node["belongs_by_one"].number(1.0);
  Estimate population;
  population.instrument_model = node["model"].text();
  population.population = members_of<PopulationFacts>(node["population"]);
  for (const auto& input : node["results"].elements())
    population.provenance.inputs.push_back({input["file"].text(), input["sha256"].text()});
  read_numbers(node, population);
  use.population = std::make_shared<const Estimate>(std::move(population));
  if (with_prior.absent()) return use;
  Estimate estimate;
  read_numbers(with_prior, estimate);
  use.with_prior = std::make_shared<const Estimate>(std::move(estimate));
  return use;
}

Estimate estimate_of(const Node& top) {
  Estimate estimate;
  top["tumble"].text();
  estimate.method = top["method"].text();
  estimate.title = top["title"].text();
  const auto instrument = top["instrument"];
  estimate.instrument_model = instrument["model"].text();
  estimate.instrument_serial = instrument["serial"].text();
  read_numbers(top, estimate);
  for (const auto& node : top["tables"].elements()) estimate.tables.push_back(table_of(node));
  for (const auto& node : top["curves"].elements()) estimate.curves.push_back(members_of<Curve>(node));
  estimate.fit = members_of<Fit>(top["fit"]);
  for (const auto& node : top["findings"].elements())
    estimate.findings.push_back(finding_of(node, estimate.parameters));
  for (const auto& node : top["verdicts"].elements()) estimate.verdicts.push_back(verdict_of(node));
  estimate.provenance = provenance_of(top["provenance"]);
  if (!estimate.provenance.memory) estimate.provenance.memory = legacy::memory_of(estimate.findings);
  if (const Node models = top.optional("models"); !models.absent())
    estimate.models = error_model::models_of(models, estimate.parameters.size());
  else
    estimate.models = error_model::legacy_models(estimate);
  if (const Node facts = top.optional("population"); !facts.absent())
    estimate.population = members_of<PopulationFacts>(facts);
  if (const Node prior = top.optional("prior"); !prior.absent())
    estimate.prior = std::make_shared<const PriorUse>(prior_of(prior, top.optional("with_prior")));
  return estimate;
}

/// Line and column of a byte of a file, counted from 1.
Where place_of(const std::string& text, std::size_t byte, const std::string& file) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte == 0 ? 0 : byte - 1, text.size()));
  const auto start = std::find(std::make_reverse_iterator(end), text.rend(), '\n').base();
  const auto line = static_cast<std::size_t>(std::count(text.begin(), end, '\n')) + 1;
  const auto column = static_cast<std::size_t>(end - start) + 1;
  return {.file = file,
          .line = line,
          .column = column,
          .place = say("{}", Name{fmt::format("{}:{}:{}", file, line, column)})};
}

/// Each problem once, in the order of the document, the first fifty of them.
Problems for_people(const Problems& problems, const std::string& file) {
  constexpr std::size_t most = 50;
  const Where where{.file = file, .place = say("{}", Name{file})};
  Problems result;
  std::set<std::string> seen;
  for (const auto& problem : problems) {
    if (seen.insert(problem.text()).second && seen.size() <= most) result.push_back(within(where, problem));
  }
  if (seen.size() > most) result.push_back(within(where, say("and {} more", seen.size() - most)));
  return result;
}

/// Looks for members that are there twice: of two values the last would count, and such a file has two authors. A pass of
/// its own, since nlohmann looks at all elements of an array for each where it is to call back.
class Twice final : public nlohmann::json_sax<nlohmann::json> {
 public:
  bool start_object(std::size_t) override { return open_.emplace_back(), true; }
  bool end_object() override { return open_.pop_back(), true; }
  bool key(std::string& name) override {
    if (!open_.back().insert(name).second) problems.push_back(say("'{}' is there twice in one object", name));
    return true;
  }
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(std::int64_t) override { return true; }
  bool number_unsigned(std::uint64_t) override { return true; }
  bool number_float(double, const std::string&) override { return true; }
  bool string(std::string&) override { return true; }
  bool binary(nlohmann::json::binary_t&) override { return true; }
  bool start_array(std::size_t) override { return true; }
  bool end_array() override { return true; }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override { return false; }

  Problems problems = {};

 private:
  std::vector<std::unordered_set<std::string>> open_ = {};
};

nlohmann::json parsed(const std::string& text, const std::string& file) {
  try {
    auto document = nlohmann::json::parse(text);
    Twice twice;
    nlohmann::json::sax_parse(text, &twice);
    if (!twice.problems.empty()) throw Error{Error::Kind::bad_file, for_people(twice.problems, file)};
    return document;
  } catch (const nlohmann::json::parse_error& error) {
    if (std::filesystem::path(file).extension() != ".json" && file.find('.') != std::string::npos)
      throw Error{Error::Kind::bad_file, in_file(file, "not JSON: a result of identify is expected here")};
    throw Error{Error::Kind::bad_file,
                Problem(place_of(text, error.byte, file), "not JSON: no valid value here, or the file ends too early")};
  } catch (const nlohmann::json::exception&) {
    throw Error{Error::Kind::bad_file, in_file(file, "a number is too large for a double")};
  }
}

}  // namespace

Estimate estimate_from_json(const std::string& text, const std::string& file) {
  const auto document = parsed(text, file);
  Problems problems;
  auto estimate = estimate_of(Node{&document, "", &problems});
  if (!problems.empty()) throw Error{Error::Kind::bad_file, for_people(problems, file)};
  return estimate;
}

Findings findings_from_json(const std::string& text, const std::string& file) {
  const auto document = parsed(text, file);
  Problems problems;
  Findings findings;
  for (const auto& node : Node{&document, "", &problems}.elements()) findings.push_back(finding_of(node));
  if (!problems.empty()) throw Error{Error::Kind::bad_file, for_people(problems, file)};
  return findings;
}

}  // namespace tumble
