#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/wire/controller/body.hpp"
#include "tumble/wire/controller/words.hpp"

namespace tumble::controller {

namespace {

std::string known_texts(const ControllerWords& words) {
  std::vector<std::string> known;
  for (const auto& [text, meaning] : words) known.push_back(text);
  return fmt::format("{}", fmt::join(known, ", "));
}

/// Whether a text is one of a key: "*Fault*" is any that holds Fault.
bool fits(std::string_view key, std::string_view text) {
  const bool before = key.starts_with('*'), behind = key.size() > 1 && key.ends_with('*');
  if (before) key.remove_prefix(1);
  if (behind) key.remove_suffix(1);
  if (before && behind) return text.find(key) != std::string_view::npos;
  return before ? text.ends_with(key) : behind ? text.starts_with(key) : text == key;
}

/// The text that a device writes for a key; for "*" the meaning itself.
std::string written(const ControllerWords::value_type& word) {
  std::string text = word.first;
  std::erase(text, '*');
  return text.empty() ? word.second : text;
}

void put_words(const Controller& controller, const Content& content, ControllerReply& reply) {
  for (const auto& [name, text] : content.words) {
    const auto words = controller.words.find(name);
    if (words == controller.words.end()) {
      reply.words[name] = text;
      continue;
    }
    const auto found = std::ranges::find_if(words->second, [&](const auto& known) { return fits(known.first, text); });
    if (found == words->second.end())
      reply.problem =
          say("unknown text '{}' for {} (known: {})", shown(text), Name{name}, Name{known_texts(words->second)});
    else
      reply.words[name] = found->second;
  }
}

void put_bits(const Controller& controller, const Content& content, ControllerReply& reply) {
  for (const auto& bits : controller.bits) {
    const auto number = content.values.find(bits.from);
    if (number == content.values.end()) continue;
    const auto word = word_of_bits(bits, number->second);
    if (word)
      reply.words[bits.word] = *word;
    else
      reply.problem = say("{} = {:.12g} has no meaning as {}", Name{bits.from}, number->second, Name{bits.word});
  }
}

}  // namespace

std::optional<std::string> word_of_bits(const ControllerBits& bits, double number) {
  if (!(number >= 0.0 && number <= 4294967295.0 && number == std::floor(number))) return std::nullopt;
  const auto raw = static_cast<std::uint32_t>(number);
  for (const auto& rule : bits.rules)
    if ((raw & rule.mask) == rule.equals) return rule.means;
  return std::nullopt;
}

std::optional<double> bits_of_word(const ControllerBits& bits, const std::string& word) {
  std::uint32_t against = 0;  // bits that keep the rules before from holding
  for (const auto& rule : bits.rules) {
    const std::uint32_t number = (against & ~rule.mask) | rule.equals;
    if (rule.means == word && word_of_bits(bits, number) == word) return number;
    if (rule.equals == 0) against |= rule.mask & (~rule.mask + 1u);
  }
  return std::nullopt;
}

ControllerReply meaning_of(const Controller& controller, const Content& content, const ControllerRequest& request) {
  ControllerReply reply{request.verb};
  reply.axis = request.axis;
  if (content.axis && *content.axis != request.axis) {
    reply.problem = say("a reply of axis {}, but axis {} was asked",
                        Name{controller.axes.at(static_cast<std::size_t>(*content.axis - 1))},
                        Name{controller.axes.at(static_cast<std::size_t>(request.axis - 1))});
    return reply;
  }
  put_words(controller, content, reply);
  put_bits(controller, content, reply);
  if (!reply.problem.empty()) {
    reply.words.clear();
    return reply;
  }
  reply.values = content.values;
  const std::string mine = fmt::format(".{}", request.axis);
  for (const auto& [key, value] : content.values)
    if (key.ends_with(mine)) reply.values[key.substr(0, key.size() - mine.size())] = value;
  return reply;
}

Content content_of(const Controller& controller, const ControllerReply& reply, const ControllerRequest& request) {
  Content content{reply.values, reply.words, request.axis};
  for (const auto& [key, value] : request.values) content.values.emplace(key, value);
  for (auto& [name, text] : content.words) {
    const auto words = controller.words.find(name);
    if (words == controller.words.end()) continue;
    const auto found = std::ranges::find(words->second, text, &ControllerWords::value_type::second);
    if (found == words->second.end())
      throw Error(Error::Kind::bad_input,
                  say("{}: this controller has no text for the {} '{}'", Name{controller.name}, Name{name}, text));
    text = written(*found);
  }
  for (const auto& bits : controller.bits) {
    const auto word = reply.words.find(bits.word);
    if (word == reply.words.end() || content.values.contains(bits.from)) continue;
    const auto number = bits_of_word(bits, word->second);
    if (!number)
      throw Error(Error::Kind::bad_input, say("{}: this controller has no bits for the {} '{}'", Name{controller.name},
                                              Name{bits.word}, word->second));
    content.values[bits.from] = *number;
  }
  return content;
}

}  // namespace tumble::controller
