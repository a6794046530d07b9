#include "core/ledger.h"

#include <algorithm>
#include <cmath>

namespace wick {

namespace {

double sum(const std::map<std::string, double>& terms) {
  double total = 0.0;
  for (const auto& [term, amount] : terms) total += amount;
  return total;
}

void visit_terms(StateVisitor& visitor, std::string_view name, std::map<std::string, double>& terms) {
  visitor.group(name, [&] {
    std::vector<std::string> names;
    std::vector<double> amounts;
    for (const auto& [term, amount] : terms) {
      names.push_back(term);
      amounts.push_back(amount);
    }
    visitor.array("names", names);
    visitor.array("amounts", amounts);
    terms.clear();
    for (std::size_t i = 0; i < names.size(); ++i) terms[names[i]] = amounts[i];
  });
}

}  // namespace

void Ledger::open() {
  opening_ = total_stock() - total_flow();
}

double Ledger::total_stock() const {
  return sum(stocks_);
}

double Ledger::total_flow() const {
  return sum(flows_);
}

double Ledger::largest_amount() const {
  double largest = std::abs(opening_);
  for (const auto& [term, amount] : stocks_) largest = std::max(largest, std::abs(amount));
  for (const auto& [term, amount] : flows_) largest = std::max(largest, std::abs(amount));
  return largest;
}

double Ledger::relative_error() const {
  const double scale = largest_amount();
  const double gap = std::abs(total_stock() - opening_ - total_flow());
  return scale > 0.0 ? gap / scale : 0.0;
}

void Ledger::visit(StateVisitor& visitor) {
  visit_terms(visitor, "stocks", stocks_);
  visit_terms(visitor, "flows", flows_);
  visitor.value("opening", opening_);
}

}  // namespace wick
