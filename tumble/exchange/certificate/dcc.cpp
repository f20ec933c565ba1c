#include "tumble/exchange/certificate.hpp"
namespace tumble {
std::string certificate_dcc(const Certificate&, const std::string&) { return {}; }
}
