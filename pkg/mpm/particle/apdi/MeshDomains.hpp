// SPDX-License-Identifier: GPL-2.0-or-later
// The domains of an APDI body: how they are made, moved with their vertices, loaded, looked at and taken out
// of the mesh.
#pragma once

#include "mpm/particle/apdi/MeshTransfers.hpp"
#include "mpm/particle/apdi/removeDomains.hpp"
#include "mpm/particle/apdi/splitDomain.hpp"

namespace mpm {

template <int Dim> class MeshDomains : public MeshTransfers<Dim>, public Mesh<Dim>, public Distortion<Dim> {
  public:
    using Base = MeshTransfers<Dim>;
    using Base::particles, Base::NC, Base::Base;
    using typename Base::NF;

    // --- making -------------------------------------------------------------------------------------
    void build(const Geometry<Dim>& geometry) override {
        mesh_.vertices.create(geometry.points);
        mesh_.corner = geometry.cells;
        mesh_.vertices.hanging.set(geometry.slaves, geometry.masters, geometry.weights);

        const int domains = mesh_.domains();
        std::vector<Vec<Dim>> centres(domains, Vec<Dim>::Zero());
        std::vector<double> volumes(domains);
        hourglass_.reference.resize(domains);
        for (int p = 0; p < domains; ++p) {
            const Corners<Dim> X = mesh_.cornersOf(p);
            Base::inShape(numbersOf<Dim>(X), [&](const auto& shape) {
                require(shape.volume > 0 && smallestCorner(shape, numbersOf<Dim>(X)) > 0, "APDI in '",
                        Base::bodyName, "': domain ", p, " near ", place(Vec<Dim>(X.col(0))),
                        " is inverted or concave; mend the mesh");
                for (int a = 0; a < NC; ++a) centres[p] += shape.w[a] * X.col(a);
                volumes[p] = shape.volume;
            });
            hourglass_.setReference(p, X);
        }
        Base::create(centres, volumes);
        Base::restored();
    }

    std::vector<Field*> fields() override {
        auto& vertices = mesh_.vertices;
        return {&vertices.position, &vertices.reference, &vertices.velocity, &hourglass_.reference,
                &vertices.hanging.weight};
    }
    std::vector<std::pair<std::string, std::vector<int>*>> tables() override {
        auto all = Base::tables();
        all.insert(all.end(), {{"corners", &mesh_.corner},
                               {"slaves", &mesh_.vertices.hanging.slaves},
                               {"masters", &mesh_.vertices.hanging.masters}});
        return all;
    }
    size_t bytes() const override {
        return sizeof(int) * (mesh_.corner.size() + mesh_.rowEnd.size()) + mesh_.vertices.bytes() +
               Base::carried_.bytes() + Base::skew_.bytes() + hourglass_.bytes();
    }

    Mesh<Dim>* mesh() override { return this; }
    Distortion<Dim>* distortion() override { return this; }

    // --- mesh: vertices move with the velocity field that enters the velocity gradient --------------
    void takeVelocity(ParallelRegion& region, const typename NF::Velocity* nodes) override {
        std::array<double*, Dim> velocity;
        for (int k = 0; k < Dim; ++k) velocity[k] = mesh_.vertices.velocity.plane(k);
        mesh_.vertices.gather(
            region, nodes, velocity,
            [](const typename NF::Velocity* in, int count, const std::array<double*, Dim>& out) {
                NodeLanes<Dim>::unpackVelocity(in, count, out);
            });
    }
    void advance(ParallelRegion& region, double dt) override { mesh_.vertices.advance(region, dt); }
    double workOf(int begin, int end) const override { return mesh_.workOf(begin, end); }

    const std::vector<int>& cornerTable() const override { return mesh_.corner; }
    Field& vertexPositions() override { return mesh_.vertices.position; }
    Field& vertexVelocities() override { return mesh_.vertices.velocity; }

    void addVertexForce(int v, const Vec<Dim>& force, typename NF::Sum* nodes) const override {
        Base::forNodes(v, [&](int node, double part, double S) {
            for (int k = 0; k < Dim; ++k)
                nodes[node].set(NF::force(k), nodes[node][NF::force(k)] + part * S * force[k]);
        });
    }
    void strains(int p, const typename Mesh<Dim>::EachStrain& each, double* stiffness) const override {
        constexpr int patterns = Mesh<Dim>::patterns;
        const auto corner = mesh_.cornerNumbersOf(p);
        const typename HourglassControl<Dim>::DeformedPattern deformed(hourglass_, particles);
        Base::inShape(corner, [&](const auto& closed) {
            const Shape<Dim> shape(closed);
            for (int a = 0; a < NC; ++a) {
                double gamma[patterns], given[patterns];
                for (int m = 0; m < patterns; ++m) gamma[m] = hourglass_.gammaOf(closed, deformed, p, m, a);
                Base::forNodes(mesh_.corner[NC * p + a], [&](int node, double part, double S) {
                    for (int m = 0; m < patterns; ++m) given[m] = part * S * gamma[m];
                    each(node, part * shape.w[a] * S, Vec<Dim>(part * S * shape.g[a]),
                         part * S * hoopOf(closed, a), given);
                });
            }
        });
        for (int m = 0; m < patterns; ++m) stiffness[m] = hourglass_.stiffnessOf(p, m);
    }
    void amplitude(int p, double (*h)[Dim]) const override {
        const typename HourglassControl<Dim>::DeformedPattern deformed(hourglass_, particles);
        const HourglassAmplitude<Dim> all = hourglass_.amplitude(mesh_, deformed, p);
        std::copy(all.data(), all.data() + all.size(), &h[0][0]);
    }
    double finishStep() override { return beam_.isHere() ? beam_.finishStep(mesh_, particles) : 0; }
    int beamRows(int p, const typename Mesh<Dim>::EachRow& each,
                 typename Mesh<Dim>::Rows& rows) const override {
        int count = 0;
        if (!beam_.isHere()) return count;
        beam_.ifTells(p, mesh_, particles,
                      [&](const auto&... told) { count = addRows(told..., each, rows); });
        beam_.ties().ifTied(p, [&](const auto& tie) { count = addRows(tie, each, rows); });
        return count;
    }
    double longestEdge(int p) const override {
        return std::sqrt(mesh_.longestSquare(p, mesh_.vertices.position));
    }
    double initialEdge(int p) const override {
        return std::sqrt(mesh_.longestSquare(p, mesh_.vertices.reference));
    }

    // --- distortion ---------------------------------------------------------------------------------
    std::vector<Distorted> distorted() const override { return Base::distorted_.all(); }
    std::vector<Piece<Dim>> split(int p, const Vec<Dim>& halfSize) const override {
        return splitDomain<Dim>(p, mesh_.cornersOf(p), vectorAt<Dim>(particles.position, p), halfSize);
    }
    void remove(const std::vector<int>& gone) override {
        const std::vector<int> kept = removeDomains(mesh_, gone);
        hourglass_.reference.select(kept);
        for (Field* field : particles.fields()) field->select(kept);
        Base::restored();
        Base::regroup();
        Base::distorted_.clear();
    }
    QualityReport qualityReport(double limit) const override { return reportQuality(mesh_, limit); }
    double minJacobian() const override {
        return Base::grid.inGeometry(
            [&](auto isRound) { return smallestJacobian<isRound>(mesh_, particles.initialVolume); });
    }
    double hourglass() const override { return hourglass_.largestAmplitude(mesh_, particles, Base::grid); }
    double hourglassEnergy() override {
        double total = 0;
        forStiffChunks([&](int begin, int end) { total += hourglass_.energy(mesh_, particles, begin, end); });
        return total;
    }

  private:
    using Base::mesh_, Base::hourglass_, Base::beam_;

    using BeamElement = typename Beam<Dim>::Element;

    int addRows(const BeamElement& element, const typename Beam<Dim>::Vertices& vertices,
                const typename BeamElement::Strained& s, int first, int end,
                const typename Mesh<Dim>::EachRow& each, typename Mesh<Dim>::Rows& rows) const {
        constexpr int most = Mesh<Dim>::mostRows;
        static_assert(BeamElement::rows <= most * BeamElement::rowSets);
        for (int r = first; r < end; ++r) {
            rows.stiffness[r - first] = element.stiffness(r);
            rows.force[r - first] = rows.stiffness[r - first] * s.e[r];
        }
        for (int a = 0; a < BeamElement::corners; ++a)
            Base::forNodes(vertices[a], [&](int node, double part, double S) {
                double row[most][Dim] = {};
                for (int r = first; r < end; ++r)
                    for (int k = 0; k < Dim; ++k) row[r - first][k] = part * S * s.gradient[r][a][k];
                each(node, row);
            });
        return end - first;
    }

    // A row for each axis; a domain with a tie is not the first of a stack.
    int addRows(const typename BeamTies<Dim>::Tie& tie, const typename Mesh<Dim>::EachRow& each,
                typename Mesh<Dim>::Rows& rows) const {
        const Vec<Dim> gap = BeamTies<Dim>::gap(mesh_, tie);
        for (int k = 0; k < Dim; ++k) {
            rows.stiffness[k] = tie.k;
            rows.force[k] = tie.k * gap[k];
        }
        const auto add = [&](int vertex, double share) {
            Base::forNodes(vertex, [&](int node, double part, double S) {
                double row[Mesh<Dim>::mostRows][Dim] = {};
                for (int k = 0; k < Dim; ++k) row[k][k] = share * part * S;
                each(node, row);
            });
        };
        add(tie.vertex, 1);
        add(tie.right, tie.part(0));
        add(tie.left, tie.part(1));
        return Dim;
    }

    // visit(begin, end) for domains whose stiffness against patterns is that of now.
    template <class Visit> void forStiffChunks(Visit&& visit) {
        for (int begin = 0; begin < particles.size(); begin += chunkSize) {
            const int end = std::min(particles.size(), begin + chunkSize);
            hourglass_.takeStiffness(begin, end, Base::stiffness, Base::shearStrength);
            visit(begin, end);
        }
    }
};

} // namespace mpm
