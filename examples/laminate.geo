// The mesh of laminate.hvi: gmsh -2 -format msh41 -bin laminate.geo
// Two plies of a laminate, 60 mm long and 2 mm thick each; between them a crack, then the seam.
length = 60; crack = 36; h = 2; fine = 0.6; coarse = 1.2;
Point(1) = {0, 0, 0, coarse};
Point(2) = {length, 0, 0, coarse};
Point(3) = {length, 2*h, 0, coarse};
Point(4) = {0, 2*h, 0, coarse};
Point(5) = {0, h, 0, coarse};
Point(6) = {crack, h, 0, fine};
Point(7) = {length, h, 0, fine};
Line(1) = {1, 2};
Line(2) = {2, 7};
Line(3) = {7, 3};
Line(4) = {3, 4};
Line(5) = {4, 5};
Line(6) = {5, 1};
Line(7) = {5, 6};
Line(8) = {6, 7};
Curve Loop(1) = {1, 2, -8, -7, 6};
Curve Loop(2) = {7, 8, 3, 4, 5};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Physical Curve("held") = {2, 3};
Physical Curve("tip") = {5};
Physical Curve("crack") = {7};
Physical Curve("seam") = {8};
Physical Surface("lower") = {1};
Physical Surface("upper") = {2};
