#include <fmt/format.h>

#include <array>
#include <cmath>

#include "tumble/report/html/html.hpp"
#include "tumble/report/names.hpp"

namespace tumble::html {
namespace {

/// So many columns have room for their numbers on a sheet; more are colours alone, with the number where one points.
constexpr std::size_t most_numbers = 10;

std::string two_digits(double r) { return std::lround(100.0 * r) == 0 ? "0" : number(fmt::format("{:.2f}", r)); }

double correlation_of(const Estimate& estimate, std::size_t i, std::size_t j) {
  const auto& covariance = estimate.covariance;
  return i == j ? 1.0 : covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
}

/// White at 0 to blue at +1 and orange at -1.
std::string heat_cell(double r, bool with_number) {
  if (!std::isfinite(r)) return "<td>–</td>";
  const double depth = std::min(1.0, std::abs(r));
  const std::array<double, 3> full = r > 0 ? std::array{0.0, 90.0, 160.0} : std::array{190.0, 80.0, 0.0};
  std::string colour = "#";
  for (const double channel : full) colour += fmt::format("{:02x}", std::lround(255.0 + depth * (channel - 255.0)));
  if (!with_number) return fmt::format("<td style=\"background:{}\" title=\"{}\"></td>", colour, two_digits(r));
  return fmt::format("<td style=\"background:{}{}\">{}</td>", colour, depth > 0.55 ? ";color:#fff" : "", two_digits(r));
}

/// The pairs that the data hardly separate, in words.
std::string strong_pairs(const Estimate& estimate, const Words& words) {
  constexpr double strong = 0.9;
  constexpr std::size_t most = 10;
  std::size_t count = 0;
  std::string text;
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    for (std::size_t j = i + 1; j < estimate.parameters.size(); ++j) {
      const double r = correlation_of(estimate, i, j);
      if (!(std::abs(r) >= strong) || ++count > most) continue;
      if (!text.empty()) text += words("next_pair");
      text += words.with("pair", escaped(readable_name(words.language, estimate.parameters[i].name, estimate.method)),
                         escaped(readable_name(words.language, estimate.parameters[j].name, estimate.method)),
                         number(fmt::format("{:.3f}", r)));
    }
  }
  if (count == 0) return "<p>" + words("no_strong_pair") + "</p>\n";
  if (count > most) text += words.with("more_pairs", std::to_string(count - most));
  return "<p>" + words.with("strong_pairs", text) + "</p>\n";
}

std::string heat_map(const Estimate& estimate, const Words& words) {
  const auto count = estimate.parameters.size();
  const bool with_numbers = count <= most_numbers;
  std::string text = fmt::format(
      "<div class=\"wide\" tabindex=\"0\"><table class=\"heat{}\">\n<caption>{}</caption>\n<thead><tr><td></td>",
      with_numbers ? "" : " dense", words(with_numbers ? "correlation_caption" : "correlation_colours"));
  for (std::size_t j = 0; j < count; ++j) {
    text += fmt::format("<th scope=\"col\" title=\"{}\">{}</th>",
                        escaped(readable_name(words.language, estimate.parameters[j].name, estimate.method)), j + 1);
  }
  text += "</tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < count; ++i) {
    text += fmt::format("<tr><th scope=\"row\">{} {}</th>", i + 1,
                        escaped(readable_name(words.language, estimate.parameters[i].name, estimate.method)));
    for (std::size_t j = 0; j <= i; ++j) text += heat_cell(correlation_of(estimate, i, j), with_numbers);
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

}  // namespace

std::string correlation(const Estimate& estimate, const Words& words) {
  constexpr std::size_t most = 40;
  const auto count = estimate.parameters.size();
  if (count < 2) return {};
  const auto shown_matrix =
      count <= most ? heat_map(estimate, words) : "<p>" + words.with("large_matrix", std::to_string(count)) + "</p>\n";
  return "<section id=\"correlation\">\n<h2>" + words("correlation") + "</h2>\n" + strong_pairs(estimate, words) +
         shown_matrix + "</section>\n";
}

}  // namespace tumble::html
