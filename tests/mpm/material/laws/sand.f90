! SPDX-License-Identifier: GPL-2.0-or-later
! Hypoplastic sand of Wu, Bauer & Kolymbas 1996, Mech. Mater. 23, 45-69, without void ratio:
!   rate(s) = c1 tr(s) D + c2 tr(s D)/tr(s) s + (c3 s s + c4 dev(s) dev(s))/tr(s) |D|,  props = c1 .. c4
include 'umat.inc'
  real(8) :: s(3, 3), d(3, 3), dev(3, 3), first(3, 3), tr
  integer :: k, n, i, j
  integer, parameter :: steps = 20, row(6) = (/1, 2, 3, 1, 1, 2/), column(6) = (/1, 2, 3, 2, 3, 3/)
  do k = 1, 6
    s(row(k), column(k)) = stress(k)
    s(column(k), row(k)) = stress(k)
    d(row(k), column(k)) = dstran(k) / merge(1, 2, k < 4) / steps
    d(column(k), row(k)) = d(row(k), column(k))
  end do
  do n = 1, steps
    first = rate(s)
    s = s + 0.5d0 * (first + rate(s + first))
  end do
  do k = 1, 6
    stress(k) = s(row(k), column(k))
  end do
  tr = stress(1) + stress(2) + stress(3)
  do i = 1, 6
    do j = 1, 6
      ddsdde(i, j) = props(2) * stress(i) * stress(j) / tr
    end do
    ddsdde(i, i) = ddsdde(i, i) + props(1) * tr * merge(1d0, 0.5d0, i < 4)
  end do
contains
  function rate(a)
    real(8) :: a(3, 3), rate(3, 3), trace, b(3, 3)
    trace = a(1, 1) + a(2, 2) + a(3, 3)
    b = a
    do k = 1, 3
      b(k, k) = b(k, k) - trace / 3
    end do
    rate = props(1) * trace * d + props(2) * sum(a * d) / trace * a &
      + (props(3) * matmul(a, a) + props(4) * matmul(b, b)) / trace * sqrt(sum(d * d))
  end function
end subroutine
