#include "tumble/math/stability/lag_sums.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <tuple>
#include <utility>

#include "tumble/math/parallel.hpp"
#include "tumble/math/stability/difference_kernels.hpp"

namespace tumble {
namespace {

constexpr std::size_t line = 8, most_lines = DifferenceKernels::many_lines;

/// The series as rows of `step` values: lags that are multiples of it are whole rows, and 8 columns of all rows that
/// they reach, put one after the other, fit into the first cache or hardly more, where every value then serves every
/// lag twice.
struct Level {
  std::size_t step = 1;
  std::size_t rows = 1;           ///< worked through at once
  std::vector<std::size_t> lags;  ///< [rows], ascending, at most `most_lags`
  std::size_t place = 0;          ///< of the first among all lags
};
constexpr std::size_t most_lags = 128;
constexpr std::size_t short_series = 65536;              // 512 kB: all its lags from the second cache
constexpr std::size_t first_step = 64, step_ratio = 16;  // of the levels
constexpr std::size_t shortest = 16;                     // lag of a level [rows]: below 1024 values there are no rows
constexpr std::size_t fewest_rows = step_ratio * shortest;  // of the last level, which takes all longer lags
constexpr std::size_t near_step = 64;  // up to which a piece is worked through by all levels while it is in the cache
constexpr std::size_t piece = 65536;

std::size_t next_step(std::size_t step) { return step == 1 ? first_step : step_ratio * step; }

std::size_t step_of(std::size_t size, std::size_t lag) {
  std::size_t step = 1;
  if (size > short_series)
    while (lag >= shortest * next_step(step) && size / next_step(step) >= fewest_rows) step = next_step(step);
  return step;
}

std::vector<Level> levels_of(std::size_t size, std::span<const std::size_t> lags) {
  std::vector<Level> levels;
  for (std::size_t i = 0; i < lags.size(); ++i) {
    const std::size_t step = step_of(size, lags[i]);
    if (levels.empty() || levels.back().step != step || levels.back().lags.size() == most_lags) {
      const bool last = size / next_step(step) < fewest_rows;
      const std::size_t rows = step == 1 ? 2048 : step > near_step && last ? size / step + 1 : 512;
      levels.push_back({.step = step, .rows = rows, .lags = {}, .place = i});
    }
    levels.back().lags.push_back(lags[i] / step);
  }
  return levels;
}

/// Rows whose differences count equally often in the inner sum: not those of the first rows, a lag of them, with those
/// that end in the last ones.
struct Stretch {
  std::size_t first, last;        ///< rows
  std::vector<std::size_t> into;  ///< of each lag that has differences here: 3 of its place + how often they count
};

std::vector<Stretch> stretches_of(const Level& level, std::size_t first, std::size_t last, std::size_t rows) {
  std::vector<Stretch> stretches;
  for (std::size_t row = first; row < last;) {
    Stretch stretch{row, last, {}};
    for (std::size_t g = 0; g < level.lags.size() && row + level.lags[g] < rows; ++g) {
      const std::size_t lag = level.lags[g], tail = rows - std::min(rows, 2 * lag);
      for (const std::size_t end : {lag, tail, rows - lag})
        if (row < end) stretch.last = std::min(stretch.last, end);
      stretch.into.push_back(3 * g + (row < lag ? 0 : 1) + (row < tail ? 1 : 0));
    }
    if (stretch.into.empty()) break;
    row = stretch.last;
    stretches.push_back(std::move(stretch));
  }
  return stretches;
}

/// Rows of `columns` values from the first of the first stretch on, with all rows after them that the lags reach.
void add_rows(const double* values, std::size_t columns, const std::vector<Stretch>& stretches, const Level& level,
              LagSum* sums) {
  const DifferenceKernels& kernels = difference_kernels();
  std::array<EightSums, 3 * most_lags> squares;
  std::array<std::size_t, most_lags> lags;
  std::fill_n(squares.begin(), 3 * level.lags.size(), EightSums{});
  for (std::size_t g = 0; g < level.lags.size(); ++g) lags[g] = level.lags[g] * columns;
  for (const Stretch& stretch : stretches) {
    const double* const from = values + (stretch.first - stretches.front().first) * columns;
    const std::size_t count = (stretch.last - stretch.first) * columns;
    std::size_t g = 0;
    for (std::size_t rounds = (stretch.into.size() + kernels.most_together - 1) / kernels.most_together; rounds > 0;
         --rounds) {
      const std::size_t together = (stretch.into.size() - g + rounds - 1) / rounds;
      kernels.add_lags[together - 1](from, lags.data() + g, stretch.into.data() + g, count, squares.data());
      g += together;
    }
  }
  for (std::size_t g = 0; g < level.lags.size(); ++g)
    for (int often = 0; often < 3; ++often) {
      const auto& one = squares[3 * g + often].values;
      const double sum = ((one[0] + one[1]) + (one[2] + one[3])) + ((one[4] + one[5]) + (one[6] + one[7]));
      sums[g].all += sum;
      sums[g].inner += often * sum;
    }
}

/// Terms of a level that start in these positions of the series and these columns.
struct Part {
  std::size_t first, last, first_column, last_column;
};

/// Asks for lines of these rows, which are far from each other in memory: they come while others are worked through.
void fetch(const double* x, std::size_t step, std::size_t first, std::size_t last) {
  for (std::size_t row = first; row < last; ++row)
    for (std::size_t k = 0; k < most_lines; ++k) __builtin_prefetch(x + row * step + k * line, 0, 2);
}

/// Columns of rows from `row` to `last`, of a series of `rows` such rows.
void add_columns(std::span<const double> x, const Level& level, std::size_t row, std::size_t last, std::size_t rows,
                 std::size_t column, std::size_t end, std::vector<Line>& room, LagSum* sums) {
  if (row >= last || column >= end) return;
  const auto stretches = stretches_of(level, row, last, rows);
  const double* const from = x.data() + row * level.step;
  if (level.step == 1) return add_rows(from, 1, stretches, level, sums);
  const std::size_t reached = std::min(last + level.lags.back(), rows) - row;
  const std::size_t lines = level.step <= near_step ? 1 : most_lines;
  room.resize(std::max(room.size(), lines * reached));
  for (; column + lines * line <= end; column += lines * line) {
    difference_kernels().put_lines(from + column, level.step, reached, lines, room.data());
    for (std::size_t k = 0; k < lines; ++k) {
      if (lines > 1 && column + 2 * lines * line <= end)
        fetch(from + column + lines * line, level.step, k * reached / lines, (k + 1) * reached / lines);
      add_rows(room[k * reached].values, line, stretches, level, sums);
    }
  }
  for (std::size_t columns = 0; column < end; column += columns) {
    columns = std::min(line, end - column);
    double* const narrow = room.data()->values;
    for (std::size_t i = 0; i < reached; ++i)
      std::memcpy(narrow + i * columns, from + i * level.step + column, columns * sizeof(double));
    add_rows(narrow, columns, stretches, level, sums);
  }
}

/// The last row may be shorter than the others, and columns have a row more or less.
void add_level(std::span<const double> x, const Level& level, const Part& part, std::vector<Line>& room, LagSum* sums) {
  const std::size_t whole = x.size() / level.step, ragged = x.size() % level.step;
  const std::size_t last_column = std::min(part.last_column, level.step);
  const std::size_t end = part.last == x.size() ? whole + 1 : part.last / level.step;
  for (std::size_t row = part.first / level.step; row < end; row += level.rows) {
    const std::size_t last = std::min(end, row + level.rows);
    add_columns(x, level, row, last, whole + 1, part.first_column, std::min(ragged, last_column), room, sums);
    add_columns(x, level, row, std::min(last, whole), whole, std::max(ragged, part.first_column), last_column, room,
                sums);
  }
}

/// Near levels by pieces of the series, the others by columns: both are fixed, and so are the sums. First what needs
/// the whole series, then stretches that the last cache holds, level after level.
struct Task {
  std::size_t from, to;  ///< levels
  Part part;
};

std::vector<Task> tasks_of(std::size_t size, const std::vector<Level>& levels) {
  constexpr std::size_t some_columns = 512, stretch = std::size_t{1} << 20;
  std::vector<Task> tasks;
  std::size_t near = 0;
  while (near < levels.size() && levels[near].step <= near_step) ++near;
  for (std::size_t k = near; k < levels.size(); ++k) {
    const std::size_t step = levels[k].step, positions = std::min(size, levels[k].rows * step);
    for (std::size_t first = 0; first < size; first += positions)
      for (std::size_t column = 0; column < step; column += some_columns)
        tasks.push_back({k, k + 1, {first, std::min(size, first + positions), column, column + some_columns}});
  }
  for (std::size_t first = 0; near > 0 && first < size; first += piece)
    tasks.push_back({0, near, {first, std::min(size, first + piece), 0, near_step}});
  const auto place = [&](const Task& task) {
    return std::tuple(task.part.last - task.part.first < size, task.part.first / stretch, task.from);
  };
  std::stable_sort(tasks.begin(), tasks.end(), [&](const Task& a, const Task& b) { return place(a) < place(b); });
  return tasks;
}

}  // namespace

bool has_lag_sum(std::size_t size, std::size_t lag) { return lag % step_of(size, lag) == 0; }

std::vector<LagSum> lag_sums(std::span<const double> x, std::span<const std::size_t> lags) {
  const auto levels = levels_of(x.size(), lags);
  const auto tasks = tasks_of(x.size(), levels);
  std::vector<LagSum> partial(tasks.size() * lags.size()), sums;
  parallel_for(tasks.size(), [&](std::size_t t) {
    static thread_local std::vector<Line> room;  // a task is short beside the pages of its own room
    for (std::size_t k = tasks[t].from; k < tasks[t].to; ++k)
      add_level(x, levels[k], tasks[t].part, room, partial.data() + t * lags.size() + levels[k].place);
  });
  for (std::size_t i = 0; i < lags.size(); ++i) {
    long double all = 0.0L, inner = 0.0L;  // of any number of tasks
    for (std::size_t k = i; k < partial.size(); k += lags.size()) {
      all += partial[k].all;
      inner += partial[k].inner;
    }
    sums.push_back({static_cast<double>(all), static_cast<double>(inner)});
  }
  return sums;
}

}  // namespace tumble
