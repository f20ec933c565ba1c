#include "tumble/report/error_model/json.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tumble/core/text.hpp"
#include "tumble/units/error.hpp"

namespace tumble::error_model {
namespace {

using Json = nlohmann::ordered_json;

const std::vector<std::string>& forms() {
  static const std::vector<std::string> all{"power", "magnitude", "sine", "cosine", "decay", "play"};
  return all;
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json factor_json(const TermFactor& factor) {
  Json json{{"input", name(factor.input)}};
  if (factor.input == Input::channel) json["role"] = factor.role;
  if (factor.form != TermFactor::Form::power) json["form"] = forms()[static_cast<std::size_t>(factor.form)];
  if (factor.order != 1) json["order"] = factor.order;
  if (factor.origin != 0.0) json["origin"] = factor.origin;
  if (factor.from_start) json["from_start"] = true;
  if (factor.form == TermFactor::Form::decay || factor.form == TermFactor::Form::play) json["size"] = factor.size;
  if (factor.lag) json["lag"] = *factor.lag;
  return json;
}

Json term_json(const ModelTerm& term) {
  Json products = Json::array();
  for (const Product& product : term.regressor) {
    Json factors = Json::array();
    for (const TermFactor& factor : product.factors) factors.push_back(factor_json(factor));
    products.push_back({{"weight", number(product.weight)}, {"factors", std::move(factors)}});
  }
  Json json{{"term", term.term}};
  if (term.parameter) json["parameter"] = *term.parameter;
  json["least"] = number(term.least);
  json["greatest"] = number(term.greatest);
  if (term.per_output) json["per_output"] = true;
  if (term.remains) json["remains"] = true;
  json["regressor"] = std::move(products);
  return json;
}

Json covered_json(const Covered& covered) {
  Json weights = Json::array();
  for (const auto& [input, weight] : covered.weights)
    weights.push_back({{"input", name(input)}, {"weight", number(weight)}});
  Json json{{"least", number(covered.least)}, {"greatest", number(covered.greatest)}, {"weights", std::move(weights)}};
  if (covered.noise != 0.0) json["noise"] = number(covered.noise);
  return json;
}

Json numbers_json(const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(number(value));
  return json;
}

void add_optional(const OutputModel& model, Json& json) {
  for (const auto& [key, index] :
       {std::pair{"scale", model.scale}, {"offset", model.offset}, {"spread", model.spread}, {"delay", model.delay}})
    if (index) json[key] = *index;
  if (model.by_output) json["by_output"] = true;
  if (model.misfit != 0.0) json["misfit"] = number(model.misfit);
  if (model.thermal)
    json["thermal"] = {{"smoothing", model.thermal->smoothing},
                       {"lag", model.thermal->lag},
                       {"start_window", model.thermal->start_window},
                       {"averaging", model.thermal->averaging}};
  if (model.reference_temperature) json["reference_temperature"] = *model.reference_temperature;
  for (const auto& code : model.caveats) json["caveats"].push_back(code);
  for (const Covered& covered : model.covered) json["covered"].push_back(covered_json(covered));
  if (model.in_region) json["in_region"] = true;
  if (model.measured)
    json["measured"] = {{"slope", number(model.measured->slope)},
                        {"offset", number(model.measured->offset)},
                        {"input", numbers_json(model.measured->input)},
                        {"departure", numbers_json(model.measured->departure)}};
}

Json model_json(const OutputModel& model) {
  Json json{{"role", model.role},
            {"shows", name(model.shows)},
            {"unit", model.unit.text()},
            {"recorded", model.recorded.text()},
            {"nominal", number(model.nominal)}};
  add_optional(model, json);
  json["terms"] = Json::array();
  for (const ModelTerm& term : model.terms) json["terms"].push_back(term_json(term));
  return json;
}

constexpr unsigned long long most_order = 99;

Input input_of(const Node& node) {
  const auto input = input_named(node.text());
  if (!input) node.complain(say("'{}' is not an input of an error model", node.text()));
  return input.value_or(Input::rate_x);
}

Unit unit_of(const Node& node) try { return Unit::parse(node.text()); } catch (const Error& error) {
  node.complain(reason_of(error));
  return {};
}

std::optional<std::size_t> index_of(const Node& node, std::size_t parameters) {
  if (node.absent()) return std::nullopt;
  const auto index = node.whole();
  if (index < parameters) return index;
  node.complain(say("is {}, but the result has {} parameters", index, parameters));
  return std::nullopt;
}

bool flag_of(const Node& node) { return !node.absent() && node.flag(); }

double number_of(const Node& node, double otherwise) { return node.absent() ? otherwise : node.number(NAN); }

/// A number that must not be below zero.
double size_of(const Node& node) {
  const double value = node.number(NAN);
  if (!(value >= 0.0)) node.complain(say("a number from {} is expected", 0));
  return value;
}

double size_of(const Node& node, double otherwise) { return node.absent() ? otherwise : size_of(node); }

TermFactor factor_of(const Node& node, std::size_t parameters) {
  TermFactor factor{.input = input_of(node["input"])};
  if (factor.input == Input::channel) factor.role = node["role"].text();
  if (const Node form = node.optional("form"); !form.absent())
    factor.form = static_cast<TermFactor::Form>(form.one_of(forms()));
  if (const Node order = node.optional("order"); !order.absent()) {
    const auto whole = order.whole();
    if (whole > most_order) order.complain(say("must lie between 0 and {}", most_order));
    factor.order = static_cast<int>(std::min<unsigned long long>(whole, most_order));
  }
  factor.origin = number_of(node.optional("origin"), 0.0);
  factor.from_start = flag_of(node.optional("from_start"));
  if (const Node size = node.optional("size"); !size.absent()) {
    factor.size = size_of(size);
    if (factor.size == 0.0) size.complain(say("a number above {} is expected", 0));
  }
  factor.lag = index_of(node.optional("lag"), parameters);
  return factor;
}

/// A finding that this version cannot say is of a later one: the result is read without it.
bool can_say(const std::string& code) try {
  text_of("finding", code);
  return true;
} catch (const Error&) {
  return false;
}

ModelTerm term_of(const Node& node, std::size_t parameters) {
  ModelTerm term{.term = node["term"].text(), .parameter = index_of(node.optional("parameter"), parameters)};
  term.least = node["least"].number(-std::numeric_limits<double>::infinity());
  term.greatest = node["greatest"].number(std::numeric_limits<double>::infinity());
  if (!(term.least <= term.greatest)) node["least"].complain("must not be above greatest");
  term.per_output = flag_of(node.optional("per_output"));
  term.remains = flag_of(node.optional("remains"));
  for (const Node& product : node["regressor"].elements()) {
    term.regressor.push_back({product["weight"].number(NAN), {}});
    for (const Node& factor : product["factors"].elements())
      term.regressor.back().factors.push_back(factor_of(factor, parameters));
  }
  return term;
}

Covered covered_of(const Node& node) {
  Covered covered{{}, node["least"].number(NAN), node["greatest"].number(NAN), number_of(node.optional("noise"), 0.0)};
  for (const Node& weight : node["weights"].elements()) {
    covered.weights.emplace_back(input_of(weight["input"]), weight["weight"].number(NAN));
    const auto& [input, share] = covered.weights.back();
    if (input == Input::channel) weight["input"].complain("the range of a channel is that of its terms");
    if (!std::isfinite(share) || share == 0.0) weight["weight"].complain("a number other than 0 is expected");
  }
  return covered;
}

void read_optional(const Node& node, std::size_t parameters, OutputModel& model) {
  model.scale = index_of(node.optional("scale"), parameters);
  model.offset = index_of(node.optional("offset"), parameters);
  model.spread = index_of(node.optional("spread"), parameters);
  model.delay = index_of(node.optional("delay"), parameters);
  model.by_output = flag_of(node.optional("by_output"));
  model.misfit = size_of(node.optional("misfit"), 0.0);
  if (const Node thermal = node.optional("thermal"); !thermal.absent())
    model.thermal = {size_of(thermal["smoothing"]), size_of(thermal["lag"]), size_of(thermal["start_window"]),
                     size_of(thermal.optional("averaging"), 0.0)};
  if (const Node reference = node.optional("reference_temperature"); !reference.absent())
    model.reference_temperature = reference.number(NAN);
  if (const Node caveats = node.optional("caveats"); !caveats.absent())
    for (const Node& code : caveats.elements())
      if (can_say(code.text())) model.caveats.push_back(code.text());
  if (const Node covered = node.optional("covered"); !covered.absent())
    for (const Node& one : covered.elements()) model.covered.push_back(covered_of(one));
  model.in_region = flag_of(node.optional("in_region"));
  if (model.in_region && model.covered.empty())
    node["in_region"].complain("needs covered, which says where the model holds");
  if (const Node measured = node.optional("measured"); !measured.absent()) {
    model.measured = {measured["slope"].number(NAN), measured["offset"].number(NAN), measured["input"].numbers(),
                      measured["departure"].numbers()};
    if (model.measured->input.size() != model.measured->departure.size())
      measured["departure"].complain("must have as many numbers as input");
  }
}

}  // namespace

Json models_json(const std::vector<OutputModel>& models) {
  Json json = Json::array();
  for (const OutputModel& model : models) json.push_back(model_json(model));
  return json;
}

std::vector<OutputModel> models_of(const Node& node, std::size_t parameters) {
  std::vector<OutputModel> models;
  for (const Node& one : node.elements()) {
    OutputModel& model = models.emplace_back();
    model.role = one["role"].text();
    model.shows = input_of(one["shows"]);
    if (model.shows == Input::channel) one["shows"].complain("an output shows a quantity");
    model.unit = unit_of(one["unit"]);
    model.recorded = unit_of(one["recorded"]);
    model.nominal = one["nominal"].number(NAN);
    if (!std::isfinite(model.nominal) || model.nominal == 0.0)
      one["nominal"].complain("a number other than 0 is expected");
    if (!(model.unit.dimension() == Unit::parse(unit_of(model.shows)).dimension()))
      one["unit"].complain(say("{} is no unit of {}", model.unit.text(), Name{name(model.shows)}));
    if (std::ranges::count(models, model.role, &OutputModel::role) > 1)
      one["role"].complain(say("two models are of '{}'", model.role));
    read_optional(one, parameters, model);
    for (const Node& term : one["terms"].elements()) model.terms.push_back(term_of(term, parameters));
  }
  return models;
}

}  // namespace tumble::error_model
