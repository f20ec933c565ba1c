#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/message_in.hpp"
#include "tumble/exchange/certificate.hpp"
#include "tumble/exchange/certificate/page.hpp"
#include "tumble/language/said.hpp"
#include "tumble/report/markup.hpp"
#include "tumble/version.hpp"

namespace tumble {

namespace assets {
extern const std::string_view certificate_css;
}

namespace certificate {
namespace {

// The page has no script, and no address outside it can be loaded, whatever a name tries.
constexpr const char* policy =
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'";

/// A text as a CSS string; every character that is no letter, digit or blank as its number.
std::string css_string(std::string_view text) {
  std::string result = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool plain =
        (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == ' ' || c >= 0x80;
    result += plain ? std::string(1, text[i]) : fmt::format("\\{:06x}", c);
  }
  return result + "\"";
}

/// Running head of each printed page: laboratory, number, page x of y.
std::string paged_style(const CertificateDetails& details, const Words& words) {
  const auto font = "font: 8pt sans-serif; color: #51606e";
  return fmt::format(
      "@page {{ size: A4; margin: 18mm 14mm 14mm;\n"
      "  @top-left {{ content: {0}; {3}; }}\n"
      "  @top-right {{ content: {1} counter(page) {2} counter(pages) {4}; {3}; }} }}\n",
      css_string(words("title") + " " + printable_text(details.number)), css_string(words("page")),
      css_string(words("page_of")), font, css_string(words("page_end")));
}

std::string head(const Certificate& certificate, const Words& words) {
  const auto& details = certificate.details;
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"generator\" content=\"Tumble {}\">\n<title>{} {}</title>\n<style>\n{}{}</style>\n</head>\n",
      details.language == Language::chinese ? "zh-CN" : "en", policy, version, words("title"), escaped(details.number),
      assets::certificate_css, paged_style(details, words));
}

std::string address(const Contact& contact) {
  std::vector<std::string> parts;
  const std::string place = contact.post_code.empty() ? contact.city : contact.post_code + " " + contact.city;
  for (const auto& part :
       {contact.street, place, contact.state, contact.country, contact.phone, contact.email, contact.link})
    if (!part.empty()) parts.push_back(escaped(part));
  return fmt::format("{}", fmt::join(parts, "<br>"));
}

std::string letterhead(const Certificate& certificate, const Words& words) {
  const auto& [contact, code, logo] = certificate.details.laboratory;
  return fmt::format(
      "<header>{}<div class=\"from\"><b>{}</b>{}{}</div><div "
      "class=\"number\"><span>{}</span><b>{}</b></div></header>\n",
      logo.empty() ? "" : "<img alt=\"\" src=\"" + escaped(logo) + "\">", escaped(contact.name), address(contact),
      code.empty() ? "" : fmt::format("<br>{}{}{}", words("accreditation"), words("colon"), escaped(code)),
      words("number"), escaped(certificate.details.number));
}

std::string entry(const std::string& name, const std::string& value) {
  return value.empty() ? "" : fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", name, value);
}

std::string title(const Certificate& certificate, const Words& words) {
  const auto& details = certificate.details;
  std::string text = "<h1>" + words(details.replaces.empty() ? "title" : "title_replacing") + "</h1>\n";
  if (!details.replaces.empty())
    text += "<p><b>" +
            words.with(details.replaces_reason.empty() ? "replaces" : "replaces_reason", escaped(details.replaces),
                       escaped(details.replaces_reason)) +
            "</b></p>\n";
  if (const auto seed = certificate.estimate.provenance.seed)
    text += "<p class=\"specimen\">" + words.with("specimen", std::to_string(*seed)) + "</p>\n";
  return text;
}

/// The key of the method, in Chinese with its name before it.
std::string method_html(const std::string& method, const Words& words) {
  const auto name = result_words_in(words.language, method);
  return (name ? escaped(*name) + " " : "") + "<code>" + escaped(method) + "</code>";
}

std::string parties(const Certificate& certificate, const Words& words) {
  const auto& details = certificate.details;
  const auto& item = details.item;
  std::string text = "<div class=\"parties\">\n<section><h2>" + words("instrument") + "</h2>\n<dl>";
  text += entry(words("instrument"), escaped(item.name)) + entry(words("manufacturer"), escaped(item.manufacturer)) +
          entry(words("model"), escaped(item.model)) + entry(words("serial"), escaped(item.serial)) +
          entry(words("customer_number"), escaped(item.customer_number)) + "</dl></section>\n";
  text += "<section><h2>" + words("customer") + "</h2>\n<p><b>" + escaped(details.customer.name) + "</b><br>" +
          address(details.customer) + "</p></section>\n</div>\n<dl class=\"wide\">";
  const auto date = [&](const char* key, const std::optional<Date>& day) {
    return day ? entry(words(key), words.date(*day)) : "";
  };
  text += date("received", details.received) + date("begun", details.begun) + date("ended", details.ended) +
          date("issued", details.issued) +
          entry(words("place"),
                words(("place_" + details.place).c_str()) + words("comma") + escaped(details.laboratory.contact.city));
  text += entry(words("method"), method_html(certificate.estimate.method, words)) +
          entry(words("norm"), escaped(details.norm)) + entry(words("software"), fmt::format("Tumble {}", version));
  return text + "</dl>\n";
}

std::string persons(const Certificate& certificate, const Words& words) {
  std::string text = "<section><h2>" + words("signatures") + "</h2>\n<div class=\"persons\">";
  for (const auto& person : certificate.details.persons)
    text += fmt::format("<div>{}<span>{}</span>{}</div>", escaped(person.name), escaped(person.role),
                        person.signs ? "<span>" + words("signed_by") + "</span>" : "");
  text += "</div>\n";
  if (certificate.details.signed_in_archive) text += "<p>" + words("signed_in_archive") + "</p>\n";
  return text + "</section>\n";
}

std::string remarks(const Certificate& certificate, const Words& words) {
  const auto& estimate = certificate.estimate;
  std::string items;
  const auto add = [&](const std::string& item) { items += "<li>" + item + "</li>\n"; };
  for (const auto& remark : certificate.details.remarks) add(escaped(remark));
  std::vector<std::string> unknown;
  for (const auto& parameter : estimate.parameters)
    if (!std::isfinite(parameter.value)) unknown.push_back(parameter.name);
  if (!unknown.empty()) add(words.with("not_determined", escaped(fmt::format("{}", fmt::join(unknown, ", ")))));
  for (const auto& statement : certificate.statements)
    if (statement.undermined) add(words.with("undermined", escaped(statement.parameter)));
  add(words("only_item"));
  add(words("whole_copy"));
  std::string said;
  for (const auto& finding : estimate.findings)
    if (finding.severity != Finding::Severity::info)
      said += "<li>" + escaped(placed_message_in(words.language, finding)) + "</li>\n";
  return "<section><h2>" + words("remarks") + "</h2>\n<ul>\n" + items + "</ul>\n" +
         (said.empty() ? "" : "<p>" + words("findings") + "</p>\n<ul>\n" + said + "</ul>\n") + "</section>\n";
}

std::string data(const Certificate& certificate, const Words& words) {
  std::string text = "<section><h2>" + words("data") + "</h2>\n<table>\n<tbody>\n";
  const auto row = [&](const std::string& kind, const std::string& file, const std::string& sha256) {
    text += fmt::format("<tr><td>{}</td><th scope=\"row\">{}</th><td class=\"hash\">SHA-256 {}</td></tr>\n", kind,
                        escaped(file), escaped(sha256));
  };
  row(words("result_file"), certificate.result_file, certificate.result_sha256);
  constexpr std::size_t most = 6;  // the result names all of them
  const auto& inputs = certificate.estimate.provenance.inputs;
  for (std::size_t i = 0; i < std::min(most, inputs.size()); ++i)
    row(words("recordings"), inputs[i].file, inputs[i].sha256);
  if (inputs.size() > most)
    text += fmt::format("<tr><td>{}</td><td colspan=\"2\">+ {}</td></tr>\n", words("recordings"), inputs.size() - most);
  return text + "</tbody></table></section>\n";
}

}  // namespace
}  // namespace certificate

std::string certificate_html(const Certificate& certificate) {
  using namespace certificate;
  const Words words{certificate.details.language};
  return head(certificate, words) + "<body>\n" + letterhead(certificate, words) + title(certificate, words) +
         parties(certificate, words) + conditions_table(certificate, words) + equipment_table(certificate, words) +
         results_table(certificate, words) + conformity(certificate, words) + "<section><h2>" + words("traceability") +
         "</h2>\n<p>" + escaped(certificate.details.traceability) + "</p></section>\n" + remarks(certificate, words) +
         certificate::data(certificate, words) + persons(certificate, words) + annex(certificate, words) +
         "</body>\n</html>\n";
}

}  // namespace tumble
