#include "matrix.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/parallel.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble::departures {
namespace {

Answer answer(const SimulatedTest& test) {
  try {
    return answer_of(identify(test.evidence, {}), test.truth);
  } catch (const Error& error) {
    return {.refusal = error.what(), .refusal_code = code_of_refusal(error, test)};
  } catch (const std::exception& error) {
    return {.refusal = error.what()};
  }
}

struct Sound {
  std::vector<SimulatedTest> tests;
  std::vector<Answer> answers;
};

Sound sound_tests(const Method& method, std::size_t seeds) {
  Sound sound{std::vector<SimulatedTest>(seeds), std::vector<Answer>(seeds)};
  parallel_for(seeds, [&](std::size_t i) {
    Trial trial = trials_of(method).first(i + 1);
    sound.tests[i] = simulated_test(std::move(trial.evidence), std::move(trial.truth), i + 1);
    sound.answers[i] = answer(sound.tests[i]);
  });
  return sound;
}

/// The answers to a cell. Throws Error::bad_input where its test cannot be made.
std::vector<Answer> answers_to(const Method& method, const Sound& sound, const Cell& cell) {
  std::vector<Answer> answers(sound.tests.size());
  const Unseen* unseen = find_unseen(cell.departure->name, method.name);
  const bool compared = unseen == nullptr || !unseen->of_references;
  parallel_for(sound.tests.size(), [&](std::size_t i) {
    const SimulatedTest& test = sound.tests[i];
    const double size = sizes_of(*cell.departure, test, cell.target)[cell.size];
    const SimulatedTest departed = with_departure(test, *cell.departure, cell.target, size, i + 1);
    answers[i] = answer(departed);
    answers[i].other_channels_changed = compared && other_channels_differ(test, departed);
  });
  return answers;
}

Row judged(const Method& method, const Sound& sound, const Cell& cell, const std::string& called) {
  const auto answers = answers_to(method, sound, cell);
  const Departure& departure = *cell.departure;
  const double size = sizes_of(departure, sound.tests.front(), cell.target)[cell.size];
  Row row{.cell = called, .unit = departure.unit, .size = size};
  if (!row.unit.empty()) row.size = Unit::parse(row.unit).difference_from_si(size);
  row.verdict =
      judge_cell(answers, sound.answers, departure.told_by, find_unseen(departure.name, method.name) != nullptr);
  const auto& truth = sound.tests.front().truth;
  if (row.verdict.worst < truth.size()) row.parameter = truth[row.verdict.worst].first;
  const auto refused = std::ranges::find_if(answers, [](const Answer& one) { return !one.refusal.empty(); });
  if (refused != answers.end()) row.first_refusal = refused->refusal;
  return row;
}

}  // namespace

std::string name(const Method& method, const Cell& cell, std::size_t sizes) {
  constexpr const char* times[] = {"x0.3", "x1", "x10"};
  std::string text = fmt::format("{}/{}", method.name, cell.departure->name);
  if (!cell.target.empty()) text += "/" + cell.target;
  return sizes == 1 ? text : text + "/" + times[cell.size];
}

bool is_drawn(const std::string& name, double percent) {
  std::uint64_t hash = 14695981039346656037ull;  // FNV-1a, 64 bits
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  hash ^= hash >> 32;
  return static_cast<double>(hash % 10000) < 100.0 * percent;
}

namespace {

/// Whether it holds, and nothing is said of it that is not said of sound tests: no sample was left out for it.
bool passes_unseen(const CellVerdict& verdict) {
  return verdict.handling == Handling::held && verdict.named == 0 && verdict.other_codes.empty();
}

/// The sizes of a departure that happens to a target, the greatest one first: what passes unseen there does at smaller ones.
void judge_sizes(const Method& method, const Sound& sound, const Departure& departure, const std::string& target,
                 Matrix& matrix) {
  const std::vector<double> sizes = sizes_of(departure, sound.tests.front(), target);
  bool passes = false;
  for (std::size_t s = sizes.size(); s-- > 0;) {
    const Cell cell{&departure, target, s};
    const std::string called = name(method, cell, sizes.size());
    if (passes) {
      matrix.rows.push_back({.cell = called, .verdict = {.handling = Handling::held}, .follows = true});
      continue;
    }
    try {
      matrix.rows.push_back(judged(method, sound, cell, called));
      passes = passes_unseen(matrix.rows.back().verdict);
    } catch (const std::exception& error) {
      matrix.impossible.push_back(fmt::format("{}: {}", called, error.what()));
    }
  }
}

}  // namespace

Matrix matrix_of(const Method& method, const Drawn& drawn, std::size_t seeds) {
  Matrix matrix;
  const Sound sound = sound_tests(method, seeds);
  matrix.sound = accusations_in(sound.answers);
  matrix.parameters = sound.tests.front().truth.size();
  for (std::size_t j = 0; j < matrix.parameters; ++j)
    matrix.judged += std::ranges::any_of(sound.answers, [&](const Answer& answer) {
      return j < answer.deviations.size() && !std::isnan(answer.deviations[j]);
    });
  for (const Departure& departure : departure_catalogue()) {
    if (!drawn.departure.empty() && drawn.departure != departure.name) continue;
    for (const std::string& target : targets_of(departure, sound.tests.front()))
      if (is_drawn(fmt::format("{}/{}/{}", method.name, departure.name, target), drawn.percent))
        judge_sizes(method, sound, departure, target, matrix);
  }
  return matrix;
}

Accusations accusations_of(const Method& method, std::uint64_t first, std::size_t seeds) {
  std::vector<Answer> answers(seeds);
  parallel_for(seeds, [&](std::size_t i) {
    Trial trial = trials_of(method).first(first + i);
    answers[i] = answer(simulated_test(std::move(trial.evidence), std::move(trial.truth), first + i));
  });
  return accusations_in(answers);
}

std::string text_of(const Method& method, const Matrix& matrix) {
  const auto line = [](std::string text) {
    std::ranges::replace(text, '\n', ' ');
    std::ranges::replace(text, '\t', ' ');
    return text;
  };
  std::string text =
      fmt::format("sound\t{}\t{} of {}\t{}\t{}\t{}\t{}\n", method.name, matrix.judged, matrix.parameters,
                  matrix.sound.tests, matrix.sound.warned, matrix.sound.refused, fmt::join(matrix.sound.codes, " "));
  for (const Row& row : matrix.rows) {
    if (row.follows)
      text += fmt::format("cell\t{}\t\theld\tas the greater size\t\t\t\t\t\n", row.cell);
    else
      text += fmt::format("cell\t{}\t{:.3g} {}\t{}\t{:.2f}\t{}\t{}\t{}\t{}\t{}\n", row.cell, row.size, row.unit,
                          name(row.verdict.handling), row.verdict.worst_rms, row.parameter, row.verdict.named,
                          row.verdict.refused, fmt::join(row.verdict.other_codes, " "), line(row.first_refusal));
  }
  for (const std::string& reason : matrix.impossible) text += "impossible\t" + line(reason) + "\n";
  return text;
}

}  // namespace tumble::departures
