#include "tumble/exchange/certificate/xml.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "tumble/report/utf8.hpp"

namespace tumble::certificate {
namespace {

std::string fixed(double value) {
  std::array<char, 400> text;
  return {text.data(), std::to_chars(text.begin(), text.end(), value, std::chars_format::fixed).ptr};
}

void content(Xml parent, std::string_view text, const char* language) {
  leaf(parent, "dcc:content", text);
  if (*language != 0) mark(parent.last_child(), "lang", language);
}

/// Value and uncertainty in one unit: [SI] with the identity, or [unit shown].
struct Scale {
  std::string unit;
  double factor, offset;

  double value(double si) const { return (si - offset) / factor; }
};

void univariate(Xml real, const Measured& measured, const Scale& scale) {
  const auto uncertainty = element(real, "si:measurementUncertaintyUnivariate");
  const double sd = measured.sd / scale.factor;
  if (std::isfinite(measured.lower) && std::isfinite(measured.upper)) {
    const auto interval = element(uncertainty, "si:coverageIntervalMU");
    leaf(interval, "si:valueStandardMU", decimal(sd));
    leaf(interval, "si:intervalMin", decimal(scale.value(measured.lower)));
    leaf(interval, "si:intervalMax", decimal(scale.value(measured.upper)));
    leaf(interval, "si:coverageProbability", "0.95");
    return;
  }
  const double k = expanded_uncertainty(measured).above / measured.sd;
  const auto expanded = element(uncertainty, "si:expandedMU");
  leaf(expanded, "si:valueExpandedMU", decimal(k * sd));
  leaf(expanded, "si:coverageFactor", fixed(k));
  leaf(expanded, "si:coverageProbability", "0.95");
  if (std::isinf(measured.degrees_of_freedom)) leaf(expanded, "si:distribution", "normal");
}

template <class Uncertainty>
void reals(Xml quantity, double value, const Unit& unit, const Uncertainty& write_uncertainty) {
  std::vector<Scale> scales{{dsi_unit(unit.dimension()), 1.0, 0.0}};
  if (const auto shown = dsi_unit(unit); shown && *shown != scales[0].unit)
    scales.push_back({*shown, unit.factor(), unit.offset()});
  const Xml parent = scales.size() > 1 ? element(quantity, "si:hybrid") : quantity;
  for (const auto& scale : scales) {
    const auto real = element(parent, "si:real");
    leaf(real, "si:value", decimal(scale.value(value)));
    leaf(real, "si:unit", scale.unit);
    write_uncertainty(real, scale);
  }
}

}  // namespace

std::vector<Language> languages_of(const CertificateDetails& details) {
  if (details.language == Language::english) return {Language::english};
  return {details.language, Language::english};
}

Xml element(Xml parent, const char* name) { return parent.append_child(name); }

void mark(Xml node, const char* attribute, const std::string& value) {
  node.append_attribute(attribute) = value.c_str();
}

void leaf(Xml parent, const char* name, std::string_view text) {
  std::string plain_text = printable(text);
  for (const char* not_of_xml : {"\xef\xbf\xbe", "\xef\xbf\xbf"})  // U+FFFE and U+FFFF
    for (auto at = plain_text.find(not_of_xml); at != std::string::npos; at = plain_text.find(not_of_xml, at))
      plain_text.replace(at, 3, " ");
  const auto begin = plain_text.find_first_not_of(' ');
  const auto end = plain_text.find_last_not_of(' ');
  element(parent, name)
      .text()
      .set(begin == std::string::npos ? "-" : plain_text.substr(begin, end - begin + 1).c_str());
}

void optional_leaf(Xml parent, const char* name, std::string_view text) {
  if (!text.empty()) leaf(parent, name, text);
}

std::string decimal(double value) {
  if (std::isnan(value)) return "NaN";
  std::array<char, 40> text;
  return {text.data(), std::to_chars(text.begin(), text.end(), value).ptr};
}

Xml plain(Xml parent, const char* name, std::string_view text) {
  const auto child = element(parent, name);
  content(child, text, "");
  return child;
}

Xml english(Xml parent, const char* name, std::string_view text, const CertificateDetails& details) {
  const auto child = element(parent, name);
  for (const auto language : languages_of(details)) content(child, text, code_of(language).c_str());
  return child;
}

Xml said(Xml parent, const char* name, const CertificateDetails& details, const char* key, const std::string& first,
         const std::string& second) {
  const auto child = element(parent, name);
  for (const auto language : languages_of(details))
    content(child, fmt::format(fmt::runtime(text_of(language, "certificate", key)), first, second),
            code_of(language).c_str());
  return child;
}

void quantity_value(Xml quantity, double value, const Unit& unit, const Measured* uncertainty) {
  reals(quantity, value, unit, [&](Xml real, const Scale& scale) {
    if (uncertainty != nullptr) univariate(real, *uncertainty, scale);
  });
}

void quantity_k2(Xml quantity, double value, const Unit& unit, const std::optional<double>& expanded) {
  reals(quantity, value, unit, [&](Xml real, const Scale& scale) {
    if (!expanded) return;
    const auto mu = element(element(real, "si:measurementUncertaintyUnivariate"), "si:expandedMU");
    leaf(mu, "si:valueExpandedMU", decimal(*expanded / scale.factor));
    leaf(mu, "si:coverageFactor", "2");
    leaf(mu, "si:coverageProbability", "0.95");
  });
}

}  // namespace tumble::certificate
