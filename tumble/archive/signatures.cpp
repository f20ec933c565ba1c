#include "tumble/archive/signatures.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "tumble/archive/history.hpp"
#include "tumble/archive/schema/chain.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/storage/packing.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

namespace {

using database::Row;

constexpr const char* action_of_signature = "signature";

/// "approved certificate" of the detail of an event.
void read_detail(const std::string& detail, Signature& signature) {
  const auto both = key_and_value(detail, ' ');
  signature.meaning = both ? both->first : detail;
  if (both) signature.kind = both->second;
}

/// Reads what was signed. Throws Error::bad_file where it is not what it was.
void require_unchanged(const Archive& archive, const std::string& kind, const std::string& sha256) {
  if (kind == "result")
    result_text(archive, sha256);
  else
    storage::unpack(schema::opened(archive).files(), sha256, [](std::string_view) {});
}

std::string problem_with(const Archive& archive, const Signature& signature) {
  const SignedThing thing = find_signable(archive, signature.sha256);
  if (thing.kind.empty() || thing.kind != signature.kind) return "the archive has no such " + signature.kind;
  try {
    require_unchanged(archive, thing.kind, thing.sha256);
  } catch (const Error& error) {
    return error.problems.front();
  }
  return thing.withdrawn.empty() ? "" : "what was signed does not count any more: " + thing.withdrawn;
}

}  // namespace

const std::vector<std::string>& signature_meanings() {
  static const std::vector<std::string> meanings{"reviewed", "approved"};
  return meanings;
}

SignedThing find_signable(const Archive& archive, const std::string& digits) {
  if (digits.size() < 6 || !is_hex(digits)) return {};
  return schema::guarded(archive.address(), [&] {
    auto& database = schema::opened(archive).database;
    SignedThing thing;
    std::size_t count = 0;
    const auto take = [&](const char* kind, const Row& row) {
      thing = {kind, database::text(row, 0), {database::text(row, 1), database::text(row, 2)}, database::text(row, 3)};
      ++count;
    };
    const Row range{digits, digits + "g"};
    database.visit(
        "SELECT r.sha256, u.model, u.serial, c.reason FROM results r JOIN units u ON u.id = r.unit LEFT JOIN "
        "corrections c ON c.result = r.id WHERE r.sha256 >= ? AND r.sha256 < ?",
        range, [&](const Row& row) { take("result", row); });
    database.visit(
        "SELECT f.sha256, u.model, u.serial, c.reason FROM certificates f JOIN results r ON r.id = f.result JOIN units "
        "u ON u.id = r.unit LEFT JOIN corrections c ON c.result = r.id WHERE f.sha256 >= ? AND f.sha256 < ?",
        range, [&](const Row& row) { take("certificate", row); });
    if (count > 1) throw Error(Error::Kind::bad_input, say("several things begin with '{}': give more digits", digits));
    return thing;
  });
}

void sign(Archive& archive, const std::string& digits, const std::string& meaning, const ArchiveAct& act) {
  const auto& meanings = signature_meanings();
  const SignedThing thing = find_signable(archive, digits);
  Problems problems;
  if (std::ranges::find(meanings, meaning) == meanings.end())
    problems.push_back(say("the meaning of a signature is one of {}, not '{}'{}", fmt::join(meanings, ", "), meaning,
                           did_you_mean(meaning, meanings)));
  if (act.who.empty()) problems.emplace_back("a signature is of a person: the name is missing");
  if (act.why.empty()) problems.emplace_back("a signature has a reason: say why");
  if (thing.kind.empty())
    problems.push_back(say("the archive has no result or certificate '{}'", first_digits(digits)));
  if (!thing.withdrawn.empty())
    problems.push_back(say("it does not count any more, and cannot be signed: {}", Name{thing.withdrawn}));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  require_unchanged(archive, thing.kind, thing.sha256);
  const std::string chain = schema::chain_of_unit(thing.unit.model, thing.unit.serial);
  const std::string detail = meaning + " " + thing.kind;
  schema::guarded(archive.address(), [&] {
    auto& database = schema::opened(archive).database;
    database.transact([&] {
      const auto before =
          database.ask("SELECT 1 FROM events WHERE chain = ? AND action = ? AND subject = ? AND who = ? AND detail = ?",
                       {chain, action_of_signature, thing.sha256, act.who, detail});
      if (!before.empty())
        throw Error(Error::Kind::bad_input,
                    say("{} has signed this {} as {} already", Name{act.who}, thing.kind.c_str(), Name{meaning}));
      schema::Change change(database, act.who, act.when);
      change.append(chain, {action_of_signature, thing.sha256, act.why, detail});
    });
  });
}

std::vector<Signature> signatures_of(const Archive& archive, const UnitName& unit) {
  auto signatures = schema::guarded(archive.address(), [&] {
    std::vector<Signature> all;
    schema::opened(archive).database.visit(
        "SELECT seq, time, who, subject, reason, detail FROM events WHERE chain = ? AND action = ? ORDER BY seq",
        {schema::chain_of_unit(unit.model, unit.serial), action_of_signature}, [&](const Row& row) {
          Signature one;
          one.number = database::integer(row, 0);
          one.when = database::text(row, 1), one.who = database::text(row, 2);
          one.sha256 = database::text(row, 3), one.why = database::text(row, 4);
          read_detail(database::text(row, 5), one);
          all.push_back(std::move(one));
        });
    return all;
  });
  std::map<std::string, std::string> problems;  // of each file once: it may have several signatures
  for (auto& one : signatures) {
    const auto key = one.kind + one.sha256;
    if (!problems.contains(key)) problems[key] = problem_with(archive, one);
    one.problem = problems[key];
  }
  return signatures;
}

}  // namespace tumble
