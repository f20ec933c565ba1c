#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/math/parallel.hpp"
#include "tumble/methods/north_finding/bench.hpp"

namespace tumble::north_finding {
namespace {

/// Rotation vector [rad] of a small passive rotation.
Vector3 vector_of(const Rotation& r) { return {0.5 * (r.y.z - r.z.y), 0.5 * (r.z.x - r.x.z), 0.5 * (r.x.y - r.y.x)}; }

Rotation small_rotation(Vector3 v) {
  const double angle = norm(v);
  return angle > 0.0 ? about((1.0 / angle) * v, angle) : Rotation{};
}

bool same(const View& a, const View& b) {
  const auto near = [](Vector3 p, Vector3 q, double scale) { return norm(p - q) <= 1e-13 * scale; };
  return near(a.turn.x, b.turn.x, 1.0) && near(a.turn.y, b.turn.y, 1.0) && near(a.turn.z, b.turn.z, 1.0) &&
         near(a.force, b.force, 10.0) && near(a.spin, b.spin, 1e-3);
}

/// One error of one plan's rig at its standard deviation: in all segments, or in one segment of one power-up.
struct Job {
  std::size_t plan = 0, index = 0, count = 0;
  RigError error;
  std::size_t power_up = npos, segment = npos;
  int run = 0;
};

/// A draw for each segment, and each time that a power-up was repeated.
void add_each_segment(const Bench& bench, const Job& job, std::vector<Job>& jobs) {
  const auto& evidence = bench.signals.front().evidence;
  for (std::size_t u = 0; u < evidence.power_ups.size(); ++u) {
    if (evidence.power_ups[u].plan_number != job.plan) continue;
    std::set<int> runs;
    for (const auto& signal : bench.signals)
      for (const auto& stretch : signal.evidence.stretches)
        if (stretch.power_up == u) runs.insert(stretch.run);
    for (const int run : runs)
      for (std::size_t s = 0; s < evidence.power_ups[u].rig.segments.size(); ++s) {
        jobs.push_back(job);
        jobs.back().power_up = u;
        jobs.back().segment = s;
        jobs.back().run = run;
      }
  }
}

std::vector<Job> jobs_of(const Bench& bench) {
  std::vector<Job> jobs;
  std::size_t next = 0;
  for (const auto& power_up : bench.signals.front().evidence.power_ups) {
    if (power_up.plan_number != next) continue;
    ++next;
    const auto errors = find_rig(power_up.plan->rig_kind).errors(power_up.plan->rig);
    for (std::size_t e = 0; e < errors.size(); ++e) {
      if (!(errors[e].sd > 0.0)) continue;
      const Job job{power_up.plan_number, e, errors.size(), errors[e]};
      if (errors[e].each_segment)
        add_each_segment(bench, job, jobs);
      else
        jobs.push_back(job);
    }
  }
  return jobs;
}

/// The rows that the error moves.
void move_rows(const Bench& bench, const Job& job, std::size_t power_up, std::vector<std::vector<Move>>& moves) {
  const auto& base = bench.index.base_from_level;
  const auto& one = bench.signals.front().evidence.power_ups[power_up];
  Matrix errors(job.count, one.rig.segments.size());
  for (std::size_t s = 0; s < errors.columns; ++s)
    errors(job.index, s) = job.segment == npos || job.segment == s ? job.error.sd : 0.0;
  const Attitude nominal(one, {}), disturbed(one, errors);
  for (std::size_t c = 0; c < bench.signals.size(); ++c)
    for (std::size_t r = 0; r < bench.signals[c].rows.size(); ++r) {
      const Row& row = bench.signals[c].rows[r];
      if (row.power_up != power_up || (job.run != 0 && row.run != job.run)) continue;
      const View before = nominal.at(row.at, base), after = disturbed.at(row.at, base);
      if (!same(before, after)) moves[c].push_back({r, before, after});
    }
}

/// What turns the base as a whole is part of what is looked for.
void take_out_base(const std::vector<bool>& found, std::size_t rows, Disturbance& out) {
  std::vector<Vector3> turns;
  double largest = 0.0;
  for (const auto& moves : out.moves)
    for (const auto& move : moves) {
      turns.push_back(vector_of(inverse(move.before.turn) * move.after.turn));
      largest = std::max(largest, norm(turns.back()));
    }
  if (turns.size() != rows || largest < 1e-13) return;
  for (const auto& turn : turns)
    if (norm(turn - turns.front()) > 1e-5 * largest + 1e-13) return;
  const Vector3 left{found[0] ? 0.0 : turns.front().x, found[1] ? 0.0 : turns.front().y, 0.0};
  const bool any = norm(left) > 1e-9 * largest;
  for (auto& moves : out.moves) {
    if (!any) moves.clear();
    for (auto& move : moves) {
      move.after = move.before;
      move.after.turn = move.before.turn * small_rotation(left);
    }
  }
}

}  // namespace

std::vector<Disturbance> disturbances_of(const Bench& bench, bool pitch_found, bool roll_found) {
  const auto jobs = jobs_of(bench);
  std::size_t rows = 0;
  for (const auto& signal : bench.signals) rows += signal.rows.size();
  std::vector<Disturbance> found(jobs.size());
  parallel_for(jobs.size(), [&](std::size_t k) {
    found[k] = {jobs[k].error.name, std::vector<std::vector<Move>>(bench.signals.size())};
    const auto& power_ups = bench.signals.front().evidence.power_ups;
    for (std::size_t u = 0; u < power_ups.size(); ++u)
      if (jobs[k].power_up == u || (jobs[k].power_up == npos && power_ups[u].plan_number == jobs[k].plan))
        move_rows(bench, jobs[k], u, found[k].moves);
    if (!jobs[k].error.each_segment) take_out_base({roll_found, pitch_found}, rows, found[k]);
  });
  std::erase_if(found, [](const Disturbance& one) {
    return std::ranges::all_of(one.moves, [](const auto& moves) { return moves.empty(); });
  });
  return found;
}

}  // namespace tumble::north_finding
