#include "tumble/report/error_model/json.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tumble/language/text.hpp"
#include "tumble/report/result_members.hpp"

namespace tumble {

const EnumerationWords& input_words() {
  static const EnumerationWords all = [] {
    EnumerationWords words;
    for (int i = 0; i <= static_cast<int>(Input::channel); ++i) words.emplace_back(name(static_cast<Input>(i)));
    return words;
  }();
  return all;
}

const EnumerationWords& form_words() {
  static const EnumerationWords all{"power", "magnitude", "sine", "cosine", "decay", "play"};
  return all;
}

namespace error_model {
namespace {

/// A finding that this version cannot say is of a later one: the result is read without it.
bool can_say(const std::string& code) try {
  text_of("finding", code);
  return true;
} catch (const Error&) {
  return false;
}

}  // namespace

nlohmann::ordered_json models_json(const std::vector<OutputModel>& models) {
  auto json = nlohmann::ordered_json::array();
  for (const OutputModel& model : models) {
    MembersToJson visit{JsonObject(&json.emplace_back(nlohmann::ordered_json::object()))};
    members(visit, model);
  }
  return json;
}

std::vector<OutputModel> models_of(const Node& node, std::size_t parameters) {
  std::vector<OutputModel> models;
  for (const Node& one : node.elements()) {
    OutputModel& model = models.emplace_back();
    MembersFromJson visit(one, parameters);
    members(visit, model);
    std::erase_if(model.caveats, [](const std::string& code) { return !can_say(code); });
    if (std::ranges::count(models, model.role, &OutputModel::role) > 1)
      one["role"].complain(say("two models are of '{}'", model.role));
  }
  return models;
}

}  // namespace error_model
}  // namespace tumble
