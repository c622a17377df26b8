! SPDX-License-Identifier: GPL-2.0-or-later
! Linear elasticity: props = young, poisson. A third one makes faults: 1 STOP, 2 NaN, 3 PNEWDT, 4 ERROR STOP, 5 XIT, in
! step 3 at particle 1. statev(1), if any, counts the calls; statev(2) is the sum of DROT(1, 2).
include 'umat.inc'
  real(8) :: lambda, mu
  integer :: k
  mu = props(1) / (2 * (1 + props(2)))
  lambda = 2 * mu * props(2) / (1 - 2 * props(2))
  ddsdde = 0
  ddsdde(1:3, 1:3) = lambda
  do k = 1, 3
    ddsdde(k, k) = lambda + 2 * mu
    ddsdde(k + 3, k + 3) = mu
  end do
  stress = stress + matmul(ddsdde, dstran)
  if (nstatv > 0) statev(1) = statev(1) + 1
  if (nstatv > 1) statev(2) = statev(2) + drot(1, 2)
  if (nprops < 3 .or. kinc /= 3 .or. noel /= 1) return
  select case (nint(props(3)))
  case (1); stop 'apex'
  case (2); stress(1) = stress(1) / (props(3) - props(3))
  case (3); pnewdt = 0.25d0
  case (4); error stop 7
  case (5); call xit
  end select
end subroutine
