#include <sstream>

#include "tumble/exchange/certificate/xml.hpp"
#include "tumble/formats/base64.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr const char* schema_version = "3.3.0";

void write_document(certificate::Xml root, const Certificate& certificate, const std::string& page) {
  if (page.empty()) return;
  const auto document = certificate::element(root, "dcc:document");
  certificate::said(document, "dcc:name", certificate.details, "title");
  certificate::leaf(document, "dcc:fileName", "certificate.html");
  certificate::leaf(document, "dcc:mimeType", "text/html");
  certificate::leaf(document, "dcc:dataBase64", base64_of(page));
}

}  // namespace

std::string certificate_dcc(const Certificate& certificate, const std::string& page) {
  pugi::xml_document document;
  auto declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  const auto root = certificate::element(document, "dcc:digitalCalibrationCertificate");
  certificate::mark(root, "xmlns:dcc", "https://ptb.de/dcc");
  certificate::mark(root, "xmlns:si", "https://ptb.de/si");
  certificate::mark(root, "xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance");
  certificate::mark(root, "xsi:schemaLocation", "https://ptb.de/dcc https://ptb.de/dcc/v3.3.0/dcc.xsd");
  certificate::mark(root, "schemaVersion", schema_version);
  certificate::write_administrative_data(root, certificate);
  certificate::write_results(certificate::write_measurement(root, certificate), certificate);
  write_document(root, certificate, page);
  std::ostringstream text;
  document.save(text, " ", pugi::format_indent, pugi::encoding_utf8);
  if (const auto problems = dcc_problems(text.str()); !problems.empty()) throw Error(Error::Kind::internal, problems);
  return text.str();
}

}  // namespace tumble
