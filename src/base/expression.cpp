#include "base/expression.h"

#include "base/error.h"

#include <algorithm>
#include <cctype>
#include <memory>
#include <muParser.h>
#include <stdexcept>
#include <string_view>
#include <unordered_map>

namespace pave {
namespace {

bool continues_name(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
}

std::string variable(std::size_t i) {
    return "_" + std::to_string(i);
}

struct Compiled {
    mu::Parser parser;
    std::vector<double> values; // where the parser reads
};

std::unique_ptr<Compiled> compile(const std::string& plain, std::size_t count) {
    auto compiled = std::make_unique<Compiled>();
    compiled->values.assign(count, 1.0);
    for (std::size_t i = 0; i < count; ++i) {
        compiled->parser.DefineVar(variable(i), &compiled->values[i]);
    }
    compiled->parser.SetExpr(plain);
    return compiled;
}

} // namespace

namespace {

constexpr std::string_view functions[] = {"exp", "ln", "log10", "sqrt", "abs", "min", "max"};

bool begins_name(char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}

std::string all_functions() {
    return join({std::begin(functions), std::end(functions)});
}

// How far from `begin` a number reaches: "12", ".5", "1.5e-3".
std::size_t end_of_number(const std::string& text, std::size_t begin) {
    const auto digits = [&](std::size_t at) {
        while (at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])) != 0) {
            ++at;
        }
        return at;
    };
    std::size_t end = digits(begin);
    if (end < text.size() && text[end] == '.') {
        end = digits(end + 1);
    }
    if (end < text.size() && (text[end] == 'e' || text[end] == 'E')) {
        const bool is_signed = end + 1 < text.size() && (text[end + 1] == '-' || text[end + 1] == '+');
        const std::size_t exponent = end + (is_signed ? 2 : 1);
        if (digits(exponent) > exponent) {
            end = digits(exponent);
        }
    }
    return end;
}

// A word that is no name of the study: one of the functions, or a complaint.
void check_function(const std::string& word, const std::vector<std::string>& known) {
    if (std::find(std::begin(functions), std::end(functions), word) != std::end(functions)) {
        return;
    }
    std::string problem = "\"" + word + "\" is no known name";
    if (word == "log") { // natural to some, decimal to others
        problem = "\"log\" may mean two things: ln or log10";
    } else if (const std::string near = nearest_name(word, known); !near.empty()) {
        problem += ", did you mean \"" + near + "\"?";
    }
    throw std::invalid_argument(problem + "; the functions are " + all_functions());
}

} // namespace

Expression::Expression(std::string text, const std::vector<std::string>& known) : text_(std::move(text)) {
    constexpr std::size_t longest = 1000;
    if (text_.size() > longest) {
        throw std::invalid_argument("it is longer than 1000 characters");
    }
    for (std::size_t i = 0; i < text_.size();) {
        const std::string* found = nullptr;
        if (i == 0 || !continues_name(text_[i - 1])) {
            for (const std::string& name : known) {
                const std::size_t end = i + name.size();
                if (text_.compare(i, name.size(), name) == 0 && (end == text_.size() || !continues_name(text_[end])) &&
                    (found == nullptr || name.size() > found->size())) {
                    found = &name;
                }
            }
        }
        if (found != nullptr) {
            auto at = std::find(reads_.begin(), reads_.end(), *found);
            if (at == reads_.end()) {
                at = reads_.insert(at, *found);
            }
            plain_ += variable(static_cast<std::size_t>(at - reads_.begin()));
            i += found->size();
            continue;
        }
        const char c = text_[i];
        std::size_t end = i + 1;
        if (begins_name(c)) {
            while (end < text_.size() && continues_name(text_[end])) {
                ++end;
            }
            check_function(text_.substr(i, end - i), known);
        } else if (std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.') {
            end = end_of_number(text_, i);
        } else if (std::string_view("+-*/^(), \t\r\n").find(c) == std::string_view::npos) {
            throw std::invalid_argument("it may hold numbers, names, parentheses, + - * / ^ and the functions " +
                                        all_functions());
        }
        plain_.append(text_, i, end - i);
        i = end;
    }
    try {
        const auto compiled = compile(plain_, reads_.size());
        compiled->parser.Eval();
        if (compiled->parser.GetNumResults() != 1) {
            throw std::invalid_argument("it must be one number");
        }
    } catch (const mu::ParserError& error) {
        throw std::invalid_argument(error.GetMsg());
    }
}

double Expression::value(const std::vector<double>& values) const {
    thread_local std::unordered_map<std::string, std::unique_ptr<Compiled>> kept;
    constexpr std::size_t most = 256;
    if (kept.size() > most) {
        kept.clear();
    }
    auto& compiled = kept[plain_];
    if (!compiled || compiled->values.size() != values.size()) {
        compiled = compile(plain_, values.size());
    }
    std::copy(values.begin(), values.end(), compiled->values.begin());
    return compiled->parser.Eval();
}

} // namespace pave
