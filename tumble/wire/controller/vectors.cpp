#include <fmt/format.h>

#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/wire/controller/body.hpp"

namespace tumble {

namespace {

/// The problems of one vector, each with its line.
struct VectorCheck {
  const Controller& declaration;
  const ControllerVector& vector;
  Problems& problems;

  void add(const Sentence& said) const {
    const Where table{.table = "vector", .place = say("[[vector]] {}", Name{name(vector.request.verb)})};
    problems.push_back(within(vector.place, within(table, said)));
  }
  void compare_bytes(const char* side, std::size_t line, const std::vector<std::string>& stated,
                     const std::string& made) const {
    const std::string expected = line < stated.size() ? stated[line] : "";
    if (made != expected)
      add(say("{}: '{}' is stated, and the declaration gives '{}'", side, controller::shown(expected),
              controller::shown(made)));
  }
  void compare(const ControllerReply& reply) const;
  void as_host() const;
  void as_device() const;
};

void VectorCheck::compare(const ControllerReply& reply) const {
  if (!reply.problem.empty()) return add(reply.problem);
  if (reply.refused != vector.reply.refused)
    return add(reply.refused ? say("the reply is refused: {}", reply.text) : Sentence("the reply is not refused"));
  if (!vector.reply.text.empty() && reply.text != vector.reply.text) add(say("the text is '{}'", reply.text));
  for (const auto& [name, value] : vector.reply.values) {
    const auto found = reply.values.find(name);
    const double tolerance = vector.tolerance.at(name) + 1e-9 * std::abs(value);
    if (found == reply.values.end())
      add(say("the reply has no '{}'", name));
    else if (!(std::abs(found->second - value) <= tolerance))
      add(say("{} is {:.9g} [SI], and {:.9g} is stated", Name{name}, found->second, value));
  }
  for (const auto& [name, word] : vector.reply.words) {
    const auto found = reply.words.find(name);
    if (found == reply.words.end() || found->second != word)
      add(say("{} is '{}', and '{}' is stated", Name{name},
              found == reply.words.end() ? Sentence("absent") : say("{}", Name{found->second}), word));
  }
}

void VectorCheck::as_host() const {
  ControllerHost host(declaration);
  std::vector<ControllerReply> replies;
  std::size_t line = 0, answered = 0;
  for (std::string bytes = host.ask(vector.request); !bytes.empty(); bytes = host.next(), ++line) {
    compare_bytes("host sends", line, vector.sends, bytes);
    const bool waits = host.waiting();
    const std::string answer = waits && answered < vector.replies.size() ? vector.replies[answered++] : "";
    for (const auto& reply : host.feed(answer)) replies.push_back(reply);
    if (waits && host.waiting()) break;
  }
  if (line < vector.sends.size()) add(say("{} texts to send are stated, {} were sent", vector.sends.size(), line));
  if (answered < vector.replies.size()) add("more replies are stated than were awaited");
  if (replies.size() != 1) {
    for (const auto& reply : replies)
      if (!reply.problem.empty()) add(reply.problem);
    return add("the replies that are stated do not complete the command");
  }
  compare(replies.front());
}

void VectorCheck::as_device() const {
  ControllerDevice device(declaration);
  std::size_t answered = 0;
  std::optional<ControllerRequest> last;
  for (const auto& bytes : vector.sends) {
    const auto requests = device.feed(bytes);
    for (const auto& request : requests) device.answer(vector.reply), last = request;
    const std::string answer = device.output();
    if (!answer.empty() && !vector.host_only) compare_bytes("device answers", answered, vector.replies, answer);
    answered += answer.empty() ? 0 : 1;
    for (const auto& problem : device.problems()) add(say("device: {}", problem));
  }
  if (!vector.host_only && answered != vector.replies.size())
    add(say("device answers: {} replies are stated, and it gives {}", vector.replies.size(), answered));
  const auto* command = declaration.find(vector.request.verb);
  if (!last || last->verb != command->same_as.value_or(command->verb))
    return add(say("device: it is taken for '{}'", last ? name(last->verb) : std::string()));
  for (const auto& [name, value] : vector.request.values) {
    const auto found = last->values.find(name);
    const double step = resolution_of(declaration, vector.request.verb, name, value);
    if (found != last->values.end() && std::abs(found->second - value) > step)
      add(say("device: {} is {:.9g} [SI], and {:.9g} was sent", Name{name}, found->second, value));
  }
}

}  // namespace

Problems problems_of_vectors(const Controller& declaration) {
  Problems problems;
  for (const auto& vector : declaration.vectors) {
    const VectorCheck check{declaration, vector, problems};
    try {
      check.as_host();
      check.as_device();
    } catch (const Error& error) {
      check.add(reason_of(error));
    }
  }
  return problems;
}

double resolution_of(const Controller& declaration, ControllerVerb verb, const std::string& value, double si) {
  const auto* command = declaration.find(verb);
  double coarsest = 0.0;
  if (!command) return coarsest;
  const auto consider = [&](const ControllerPiece& piece) {
    using Piece = ControllerPiece;
    if (piece.kind != Piece::Kind::number || piece.part == Piece::Part::sign) return;
    if (piece.text == value || controller::key_of(piece) == value)
      coarsest = std::max(coarsest, controller::resolution(piece, si));
  };
  for (const auto& exchange : command->exchanges) {
    for (const auto& piece : exchange.send.pieces) consider(piece);
    for (const auto& form : exchange.expect)
      for (const auto& piece : form.pieces) consider(piece);
    if (exchange.modbus) consider(exchange.modbus->number);
  }
  return coarsest;
}

}  // namespace tumble
