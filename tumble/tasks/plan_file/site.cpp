#include "tumble/tasks/plan_file/site.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::plan_file {

Site read_site(const toml::table& table, tables::FileProblems& problems) {
  tables::Section section(table, "[site]", problems);
  Site site;
  site.latitude = section.quantity("latitude", Unit::parse("deg")).value_or(0.0);
  site.longitude = section.quantity("longitude", Unit::parse("deg")).value_or(0.0);
  site.height = section.quantity("height", Unit::parse("m"));
  site.gravity = section.quantity("gravity", Unit::parse("m/s^2"));
  site.latitude_sd = section.quantity("latitude_sd", Unit::parse("arcsec"));
  if (!table.contains("latitude")) section.missing("latitude", "\"34.25 deg\"");
  if (std::abs(site.latitude) > half_pi) section.problem_at("latitude", "must be from -90 to 90 deg");
  if (std::abs(site.longitude) > two_pi) section.problem_at("longitude", "must be from -360 to 360 deg");
  if (site.latitude_sd && !(*site.latitude_sd >= 0.0 && *site.latitude_sd <= half_pi))
    section.problem_at("latitude_sd", "must be from 0 to 90 deg");
  if (std::abs(site.height.value_or(0.0)) > 1e5) section.problem_at("height", "must be from -100 to 100 km");
  if (site.gravity && !(*site.gravity > 0.0)) section.problem_at("gravity", "must be above zero");
  // what rock and relief do to gravity stays below 1e-3 of it
  else if (const double normal = normal_gravity(site.latitude, site.height.value_or(0.0));
           site.gravity && std::abs(*site.gravity / normal - 1.0) > 0.01)
    section.problem_at("gravity", say("{:g} m/s^2 is impossible: at this latitude and height it is about {:.3f} m/s^2",
                                      *site.gravity, normal));
  section.close();
  return site;
}

}  // namespace tumble::plan_file
